// A table as a spreadsheet writes it, from C++17: decimal commas, a missing cell, a column of words;
// and a regression on its columns.

#include <catamaran.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

const char path[] = "example_tables_cpp.csv";

void require(bool condition, const char* what) {
    if (!condition) {
        std::fprintf(stderr, "%s\n", what);
        std::exit(EXIT_FAILURE);
    }
}

// y = 2 + 1.5 x for each complete row.
void run() {
    std::ofstream(path) << "city;x;y\nUlm;0;2\nBonn;1;3,5\nUlm;;4\nKiel;3;6,5\nBonn;5;9,5\n";
    catamaran::table_options how;
    how.columns = "x,y,city";
    how.factors = "city";
    how.missing = catamaran::missing_cells::drop;
    const catamaran::table table = catamaran::table::read(path, how);
    std::printf("%s\n", table.reading().c_str());
    require(table.rows() == 4 && table.cols() == 3 && table.dropped_rows() == 1, "shape");
    require(table.name(1) == "y" && table.levels(0).empty(), "names");
    require(table.levels(2) == std::vector<std::string>{"Bonn", "Kiel", "Ulm"}, "levels");

    const std::vector<double> entries = table.entries();
    const auto columns = [&](std::size_t first) {
        return catamaran::row_major(&entries[first], table.rows(), 1, table.cols());
    };
    catamaran::lstsq_options with_intercept;
    with_intercept.intercept = true;
    const auto fit = catamaran::lstsq(columns(0), columns(1), {}, with_intercept);
    std::printf("y = %g + %g x\n", fit.intercepts[0], fit.coefficients[0]);
    require(std::abs(fit.intercepts[0] - 2) < 1e-12, "intercept");
    require(std::abs(fit.coefficients[0] - 1.5) < 1e-12, "slope");

    try {
        how.columns = "z";
        catamaran::table::read(path, how);
        require(false, "a column that does not exist");
    } catch (const catamaran::error& refused) {
        require(std::string(refused.what()).find("no column z") != std::string::npos, "message");
    }
}

}  // namespace

int main() {
    run();
    return std::remove(path);
}
