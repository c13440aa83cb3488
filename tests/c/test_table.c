/* Tables through the C ABI: names, missing cells, factors, options, refusals. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)
#define CHECK_TEXT(found, right) CHECK(strcmp((found), (right)) == 0)

static const char *const PATH = "test_table_of_c.csv";

static void write_file(const char *text)
{
    FILE *file = fopen(PATH, "wb");
    CHECK(file != NULL);
    if (file != NULL) {
        CHECK(fputs(text, file) >= 0);
        CHECK(fclose(file) == 0);
    }
}

static cata_table_params defaults(void)
{
    cata_table_params params;
    CHECK_STATUS(cata_table_params_init(&params, sizeof params), CATA_OK);
    return params;
}

/* The table in the file, which is of this shape. */
static cata_table *read_as(const cata_table_params *params, size_t rows, size_t columns)
{
    cata_table *table = NULL;
    size_t m = 99, n = 99;
    CHECK_STATUS(cata_table_read(PATH, params, &table), CATA_OK);
    CHECK_STATUS(cata_table_shape(table, &m, &n, NULL), CATA_OK);
    CHECK(m == rows && n == columns);
    return table;
}

static void refuse(const cata_table_params *params, cata_status status, const char *mentions)
{
    cata_table *table = NULL;
    CHECK_STATUS(cata_table_read(PATH, params, &table), status);
    CHECK_MENTIONS(mentions);
    CHECK(table == NULL);
}

static void test_numbers_and_names(void)
{
    double a[6] = {0};
    uint64_t dropped = 99;
    cata_table *table;
    write_file("ort;x;y\nUlm;1,5;2\nBonn;3,5;5\nKiel;0;-1\n");
    table = read_as(NULL, 3, 2);
    CHECK_TEXT(cata_table_name(table, 0), "x");
    CHECK_TEXT(cata_table_name(table, 1), "y");
    CHECK_TEXT(cata_table_name(table, 2), "");
    CHECK_TEXT(cata_table_name(NULL, 0), "");
    CHECK_TEXT(cata_table_reading(table),
               "separator ;, decimal comma, header, 1 text column left out (ort)");
    CHECK(cata_table_levels(table, 0) == 0 && cata_table_levels(NULL, 0) == 0);
    CHECK_STATUS(cata_table_entries(table, CATA_ROW_MAJOR, a, 2), CATA_OK);
    CHECK(a[0] == 1.5 && a[1] == 2 && a[2] == 3.5 && a[3] == 5 && a[4] == 0 && a[5] == -1);
    CHECK_STATUS(cata_table_entries(table, CATA_COL_MAJOR, a, 3), CATA_OK);
    CHECK(a[0] == 1.5 && a[1] == 3.5 && a[2] == 0 && a[3] == 2 && a[4] == 5 && a[5] == -1);
    CHECK_STATUS(cata_table_entries(table, CATA_ROW_MAJOR, a, 1), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_table_entries(table, CATA_ROW_MAJOR, NULL, 2), CATA_ERR_NULL);
    CHECK_STATUS(cata_table_shape(table, NULL, NULL, &dropped), CATA_OK);
    CHECK(dropped == 0);
    CHECK_STATUS(cata_table_shape(NULL, NULL, NULL, &dropped), CATA_ERR_NULL);
    cata_table_free(table);
    cata_table_free(NULL);
    write_file("x,id\n1.5,2\n2,9007199254740993\n3,4\n");
    table = read_as(NULL, 3, 2);
    CHECK_TEXT(cata_table_reading(table),
               "separator ,, decimal point, header, "
               "an integer beyond 2^53 rounded, in line 3, column 2 (id)");
    cata_table_free(table);
}

static void test_missing_cells(void)
{
    double a[6] = {0};
    uint64_t dropped = 0;
    cata_table *table;
    cata_table_params params = defaults();
    write_file("x,y\n1,2\nNA,3\n4,none\n");
    refuse(NULL, CATA_ERR_IO, "test_table_of_c.csv:3: column 1 (x)");
    CHECK_MENTIONS("`missing`");
    params.missing_words = "NA,none";
    params.missing = CATA_MISSING_DROP;
    table = read_as(&params, 1, 2);
    CHECK_STATUS(cata_table_shape(table, NULL, NULL, &dropped), CATA_OK);
    CHECK(dropped == 2);
    cata_table_free(table);
    params.missing = CATA_MISSING_NAN;
    params.threads = 2;
    table = read_as(&params, 3, 2);
    CHECK_STATUS(cata_table_entries(table, CATA_ROW_MAJOR, a, 2), CATA_OK);
    CHECK(isnan(a[2]) && a[3] == 3 && a[4] == 4 && isnan(a[5]));
    cata_table_free(table);
    params.missing = 3;
    refuse(&params, CATA_ERR_ARGUMENT, "params.missing");
}

static void test_factors_and_columns(void)
{
    double a[6] = {0};
    cata_table *table;
    cata_table_params params = defaults();
    write_file("ort,x,art\nUlm,1,p\nBonn,2,q\nUlm,3,p\n");
    params.factors = "ort";
    params.columns = "x,ort";
    table = read_as(&params, 3, 2);
    CHECK_TEXT(cata_table_name(table, 1), "ort");
    CHECK(cata_table_levels(table, 0) == 0 && cata_table_levels(table, 1) == 2);
    CHECK_TEXT(cata_table_level(table, 1, 0), "Bonn");
    CHECK_TEXT(cata_table_level(table, 1, 1), "Ulm");
    CHECK_TEXT(cata_table_level(table, 1, 2), "");
    CHECK_TEXT(cata_table_level(table, 0, 0), "");
    CHECK_STATUS(cata_table_entries(table, CATA_ROW_MAJOR, a, 2), CATA_OK);
    CHECK(a[0] == 1 && a[1] == 1 && a[2] == 2 && a[3] == 0 && a[4] == 3 && a[5] == 1);
    cata_table_free(table);
    params.columns = "art";
    refuse(&params, CATA_ERR_IO, "column art has words");
    params.columns = "z";
    refuse(&params, CATA_ERR_ARGUMENT, "no column z");
    params.columns = "\xff";
    refuse(&params, CATA_ERR_ARGUMENT, "params.columns: must be in UTF-8");
}

static int32_t stop(double fraction, void *user)
{
    (void)fraction, (void)user;
    return 1;
}

static void test_options(void)
{
    double a[4] = {0};
    cata_table *table;
    cata_table_params params = defaults();
    write_file("a title\n1|2\n3|4\n");
    params.skip = 1;
    params.separator = '|';
    params.header = CATA_NO;
    params.index = CATA_YES;
    table = read_as(&params, 2, 1);
    CHECK_STATUS(cata_table_entries(table, CATA_COL_MAJOR, a, 2), CATA_OK);
    CHECK(a[0] == 2 && a[1] == 4);
    cata_table_free(table);
    params.index = 3;
    refuse(&params, CATA_ERR_ARGUMENT, "params.index");
    params.index = CATA_AUTO;
    params.format = "csv";
    refuse(&params, CATA_ERR_ARGUMENT, "params.format: must be one of npy, mtx, table");
    params.format = "table";
    params.decimal = ';';
    refuse(&params, CATA_ERR_ARGUMENT, "decimal");
    params.decimal = 0;
    params.progress = stop;
    refuse(&params, CATA_ERR_CANCELLED, "cancelled");
    CHECK_STATUS(cata_table_read(NULL, NULL, &table), CATA_ERR_NULL);
    CHECK_STATUS(cata_table_read(PATH, NULL, NULL), CATA_ERR_NULL);
    table = NULL;
    CHECK_STATUS(cata_table_read("no such file", NULL, &table), CATA_ERR_IO);
    CHECK(table == NULL);
    params.struct_size = 8;
    refuse(&params, CATA_ERR_ARGUMENT, "struct_size");
}

int main(void)
{
    test_numbers_and_names();
    test_missing_cells();
    test_factors_and_columns();
    test_options();
    CHECK(remove(PATH) == 0);
    return report("test_table");
}
