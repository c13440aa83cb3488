// The header in C++17, and the layer over it, under mpirun.

#include <catamaran/mpi.hpp>

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

#include "check.hpp"

namespace {

// Whether the next allocation fails.
bool out_of_memory = false;

}  // namespace

void* operator new(std::size_t size) {
    void* const memory = out_of_memory ? nullptr : std::malloc(size ? size : 1);
    out_of_memory = false;
    return memory ? memory : throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

// Row (rank + 1, 2) on each rank.
void products(const catamaran::world& world) {
    const std::size_t rank = world.rank(), size = world.size();
    const double row[2] = {static_cast<double>(rank + 1), 2.0};
    const catamaran::symmetric product = catamaran::ata_rows(world, catamaran::row_major(row, 1, 2));
    CHECK(product.n() == 2);
    const std::vector<double> c = product.gather(world);
    const double p = static_cast<double>(size);
    CHECK(c.size() == (rank == 0 ? 4u : 0u));
    CHECK(rank != 0 ||
          (c[0] == p * (p + 1) * (2 * p + 1) / 6 && c[1] == p * (p + 1) && c[3] == 4 * p));
    const double column[2] = {1, static_cast<double>(rank)};
    const auto own = catamaran::col_major(column, 2, 1);
    CHECK(catamaran::ata_columns(world, own, 2.0).n() == size);
    CHECK(size == 1 || world.traffic().messages_sent + world.traffic().messages_received > 0);
}

// Column (1, rank) on each rank of a grid of one row.
void cyclic_products(const catamaran::world& world) {
    const auto rank = static_cast<std::int32_t>(world.rank());
    const auto n = static_cast<std::int32_t>(world.size());
    const double column[2] = {1, static_cast<double>(rank)};
    const catamaran::cyclic_view<const double> a{column, {{1, 0, 2, n, 2, 1, 0, 0, 2}}};
    const catamaran::process_grid grid{1, world.size()};
    std::vector<double> c(world.size(), 1.0), d(4, 1.0);
    catamaran::ata_cyclic(world, grid, 2.0, a, 1.0, {c.data(), {{1, 0, n, n, n, 1, 0, 0, n}}});
    for (std::int32_t i = 0; i < n; ++i) CHECK(c[static_cast<std::size_t>(i)] == 3 + 2 * i * rank);
    // The whole result is on the first rank.
    catamaran::aat_cyclic(world, grid, 1.0, a, 0.0, {d.data(), {{1, 0, 2, 2, 2, 2, 0, 0, 2}}});
    const double sum = n * (n - 1) / 2.0, squares = sum * (2 * n - 1) / 3;
    CHECK(rank != 0 || (d[0] == n && d[1] == sum && d[2] == sum && d[3] == squares));
    const catamaran::process_grid none{0, world.size()};
    CHECK(status_of([&] {
              catamaran::ata_cyclic(world, none, 1.0, a, 0.0,
                                    {c.data(), {{1, 0, n, n, n, 1, 0, 0, n}}});
          }) == CATA_ERR_ARGUMENT);
}

// The path with ten nodes on each rank.
void spectra(const catamaran::world& world) {
    const std::size_t rank = world.rank(), size = world.size(), own = 10, n = own * size;
    std::vector<std::size_t> starts{0}, columns;
    std::vector<double> entries;
    for (std::size_t i = own * rank; i < own * (rank + 1); ++i) {
        for (std::size_t j = i ? i - 1 : 0; j <= i + 1 && j < n; ++j) {
            columns.push_back(j);
            entries.push_back(i != j ? -1 : i == 0 || i == n - 1 ? 1 : 2);
        }
        starts.push_back(columns.size());
    }
    const catamaran::sparse_view rows{own, starts.data(), columns.data(), entries.data()};
    const auto pairs = catamaran::eigs(world, rows, n, 2);
    const double expected = 2 - 2 * std::cos(std::acos(-1.0) / static_cast<double>(n));
    CHECK(std::abs(pairs.values[1] - expected) < 1e-10 && pairs.vectors.size() == 2 * own);
    const std::size_t last = size - 1;
    CHECK(status_of([&] {
              catamaran::eigs(world, rows, n, 2, std::vector<double>(rank == last ? 1 : own, 1.0));
          }) == (rank == last ? CATA_ERR_SHAPE : CATA_ERR_RANK));
    catamaran::eigs_options how;
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::eigs(world, rows, n, 2, {}, how); }) == CATA_ERR_CANCELLED);
}

// b = 1 + 2 t, two rows on each rank; a third one, which is elsewhere, has no weight.
void lines(const catamaran::world& world) {
    const double first = static_cast<double>(2 * world.rank());
    const std::vector<double> t{first, first + 1, 5}, b{1 + 2 * first, 3 + 2 * first, 99};
    const std::size_t last = world.size() - 1;
    catamaran::lstsq_options how;
    how.intercept = true;
    const auto a = catamaran::row_major(t.data(), 3, 1);
    for (const auto& targets :
         {catamaran::row_major(b.data(), 3, 1), catamaran::col_major(b.data(), 3, 1)}) {
        const auto found = catamaran::lstsq(world, a, targets, {1, 1, 0}, how);
        CHECK(found.coefficients == std::vector<double>{2});
        CHECK(found.intercepts == std::vector<double>{1});
        CHECK(found.rank == 1 && found.observations == 2 * world.size());
    }
    CHECK(status_of([&] {
              const std::vector<double> weights(world.rank() == last ? 1 : 3, 1.0);
              catamaran::lstsq(world, a, catamaran::row_major(b.data(), 3, 1), weights, how);
          }) == (world.rank() == last ? CATA_ERR_SHAPE : CATA_ERR_RANK));
    how.progress = [](double) { return false; };
    CHECK(status_of([&] {
              catamaran::lstsq(world, a, catamaran::row_major(b.data(), 3, 1), {}, how);
          }) == CATA_ERR_CANCELLED);
}

// The third column is twice the first.
void columns(const catamaran::world& world) {
    std::vector<double> data(15);
    for (std::size_t i = 0; i < 5; ++i) {
        data[i] = 1;
        data[5 + i] = static_cast<double>(5 * world.rank() + i);
        data[10 + i] = 2;
    }
    std::vector<double> same(data);
    const auto found = catamaran::gram_schmidt(world, catamaran::col_major(data.data(), 5, 3));
    CHECK((found.kept == std::vector<std::size_t>{0, 1}) && found.r.size() == 6);
    CHECK(std::abs(found.r[4] - 2 * found.r[0]) < 1e-12);
    const auto r = catamaran::cholesky_qr(world, catamaran::col_major(same.data(), 5, 2));
    for (std::size_t i = 0; i < 10; ++i) CHECK(std::abs(same[i] - data[i]) < 1e-12);
    CHECK(std::abs(r[0] - found.r[0]) < 1e-12 && r[1] == 0);
    CHECK(status_of([&] {
              catamaran::cholesky_qr(world, catamaran::col_major(same.data(), 5, 2), {1});
          }) == CATA_ERR_SHAPE);
}

// One rank has no memory for its results: the others get an error, and wait for nothing.
void memory(const catamaran::world& world) {
    const std::size_t last = world.size() - 1;
    const std::vector<std::size_t> starts{0, 1}, columns{world.rank()};
    const std::vector<double> entries{1};
    const catamaran::sparse_view identity{1, starts.data(), columns.data(), entries.data()};
    double one = 1;
    const auto a = catamaran::col_major(&one, 1, 1);
    const catamaran::symmetric product = catamaran::ata_rows(world, a);
    const auto fails = [&](const auto& call) {
        out_of_memory = world.rank() == last;
        try {
            CHECK(status_of(call) == CATA_ERR_RANK && world.rank() != last);
        } catch (const std::bad_alloc&) {
            CHECK(world.rank() == last);
        }
    };
    fails([&] { catamaran::eigs(world, identity, world.size(), 1); });
    fails([&] { catamaran::lstsq(world, a, a); });
    fails([&] { catamaran::gram_schmidt(world, a); });
    fails([&] { catamaran::cholesky_qr(world, a); });
    fails([&] { product.gather(world, last); });
}

}  // namespace

int main(int argc, char** argv)
{
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    {
        const catamaran::world world(MPI_COMM_WORLD);
        products(world);
        cyclic_products(world);
        spectra(world);
        lines(world);
        columns(world);
        memory(world);
    }
    MPI_Finalize();
    return report("mpi_cpp");
}
