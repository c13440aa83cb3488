// Tables through the C++ layer.

#include <catamaran.hpp>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "check.hpp"

namespace {

using catamaran::layout;
using catamaran::table;

const char* const path = "test_table_of_cpp.csv";

using numbers = std::vector<double>;
using words = std::vector<std::string>;

void write_file(const std::string& text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    CHECK(file.good());
}

void numbers_and_names() {
    write_file("ort;x;y\nUlm;1,5;2\nBonn;3,5;5\nKiel;0;-1\n");
    table read = table::read(path);
    CHECK(read.rows() == 3 && read.cols() == 2 && read.dropped_rows() == 0);
    CHECK(read.name(0) == "x" && read.name(1) == "y" && read.name(2).empty());
    CHECK(read.reading() == "separator ;, decimal comma, header, 1 text column left out (ort)");
    CHECK((read.entries() == numbers{1.5, 2, 3.5, 5, 0, -1}));
    const table moved = std::move(read);
    CHECK((moved.entries(layout::col_major) == numbers{1.5, 3.5, 0, 2, 5, -1}));
}

void factors_and_missing_cells() {
    catamaran::table_options how;
    write_file("ort,x\nUlm,1\nBonn,NA\nUlm,3\n");
    CHECK(status_of([&] { table::read(path, how); }) == CATA_ERR_IO);
    how.factors = "ort";
    how.columns = "x,ort";
    how.missing_words = "NA";
    how.missing = catamaran::missing_cells::drop;
    const table dropped = table::read(path, how);
    CHECK(dropped.rows() == 2 && dropped.dropped_rows() == 1 && dropped.levels(0).empty());
    how.missing = catamaran::missing_cells::nan;
    const table all = table::read(path, how);
    CHECK((all.levels(1) == words{"Bonn", "Ulm"}));
    const numbers entries = all.entries();
    CHECK(entries[0] == 1 && entries[1] == 1 && std::isnan(entries[2]) && entries[3] == 0);
}

void options_and_errors() {
    catamaran::table_options how;
    write_file("a title\n1|2\n3|4\n");
    how.skip = 1;
    how.separator = '|';
    how.header = catamaran::presence::no;
    how.index = catamaran::presence::yes;
    CHECK((table::read(path, how).entries() == numbers{2, 4}));
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { table::read(path, how); }) == CATA_ERR_CANCELLED);
    how.progress = [](double) -> bool { throw std::runtime_error("mine"); };
    bool thrown = false;
    try {
        table::read(path, how);
    } catch (const std::runtime_error& error) {
        thrown = std::string(error.what()) == "mine";
    }
    CHECK(thrown);
    CHECK(status_of([] { table::read("no such file"); }) == CATA_ERR_IO);
    CHECK(status_of([] { table(nullptr); }) == CATA_ERR_NULL);
}

}  // namespace

int main() {
    numbers_and_names();
    factors_and_missing_cells();
    options_and_errors();
    CHECK(std::remove(path) == 0);
    return report("test_cpp_tables");
}
