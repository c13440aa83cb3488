// What the tests of the C++ layer share, besides check.h.

#pragma once

#include <catamaran.hpp>

#include <cstddef>
#include <string>
#include <vector>

#include "check.h"

namespace {

// The status of the error that a call throws.
template <class Call>
cata_status status_of(const Call& call) {
    try {
        call();
    } catch (const catamaran::error& error) {
        CHECK(std::string(error.what()) != "");
        return error.status();
    }
    return CATA_OK;
}

// A tridiagonal matrix of n rows, with -1 beside the diagonal.
struct tridiagonal {
    tridiagonal(std::size_t n, double inside, double end) : starts{0} {
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = i ? i - 1 : 0; j <= i + 1 && j < n; ++j) {
                columns.push_back(j);
                entries.push_back(i != j ? -1 : i == 0 || i == n - 1 ? end : inside);
            }
            starts.push_back(columns.size());
        }
    }

    catamaran::sparse_view view() const {
        return {starts.size() - 1, starts.data(), columns.data(), entries.data()};
    }

    std::vector<std::size_t> starts, columns;
    std::vector<double> entries;
};

}  // namespace
