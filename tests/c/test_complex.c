/* Products of complex matrices, in every layout, triangle and precision, against plain loops.
 *
 * With the argument "quick": small sizes on one thread, for Valgrind, as in test_products.c. */

#include <catamaran.h>

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

static size_t entry_at(int32_t layout, size_t ld, size_t i, size_t j)
{
    return layout == CATA_ROW_MAJOR ? i * ld + j : i + j * ld;
}

static size_t memory_len(int32_t layout, size_t rows, size_t cols, size_t ld)
{
    const size_t lines = layout == CATA_ROW_MAJOR ? rows : cols;
    const size_t line = layout == CATA_ROW_MAJOR ? cols : rows;
    return lines == 0 || line == 0 ? 0 : (lines - 1) * ld + line;
}

#define REAL double
#define NAME(base) base##_c64
#define LOCAL(base) base##_double
#include "complex_template.h"
#undef REAL
#undef NAME
#undef LOCAL

#define REAL float
#define NAME(base) base##_c32
#define LOCAL(base) base##_float
#include "complex_template.h"
#undef REAL
#undef NAME
#undef LOCAL

int main(int argc, char **argv)
{
    const int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    test_all_double(quick);
    test_all_float(quick);
    return report("complex");
}
