/* Slime moulds through the C ABI: the same bytes for any threads, exact evaporation, refusals, outputs untouched. */

#include <catamaran.h>

#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

/* The unit square, cut in two. */
enum { SIZE = 32 };
static const double positions[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
static const double uv[12] = {0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};
static float texture[SIZE * SIZE], other[SIZE * SIZE];

static cata_slime_params small(void)
{
    cata_slime_params params = {.struct_size = sizeof params};
    params.agents = 500;
    params.size = SIZE;
    params.seed = 3;
    return params;
}

static cata_slime *make(const cata_slime_params *params)
{
    cata_slime *slime = NULL;
    CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, uv, NULL, NULL, params, &slime),
                 CATA_OK);
    return slime;
}

static void test_threads(void)
{
    for (size_t threads = 1; threads < 4; threads++) {
        cata_slime_params params = small();
        params.threads = threads;
        cata_slime *slime = make(&params);
        CHECK_STATUS(cata_slime_step(slime, 20, NULL, NULL), CATA_OK);
        CHECK_STATUS(cata_slime_texture(slime, 0, threads == 1 ? texture : other), CATA_OK);
        CHECK(threads == 1 || memcmp(texture, other, sizeof texture) == 0);
        size_t size = 0, species = 0, faces = 0;
        uint32_t steps = 0;
        CHECK_STATUS(cata_slime_size(slime, &size, &species, &faces, &steps), CATA_OK);
        CHECK(size == SIZE && species == 1 && faces == 2 && steps == 20);
        double coverage = -1, presence = -1, given[12];
        CHECK_STATUS(cata_slime_coverage(slime, 0, &coverage, &presence), CATA_OK);
        CHECK(0 < coverage && coverage <= presence && presence <= 1 + 1e-6);
        CHECK_STATUS(cata_slime_uv(slime, given), CATA_OK);
        CHECK(memcmp(given, uv, sizeof uv) == 0);
        cata_slime_free(slime);
    }
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    cata_slime_params params = small();
    cata_slime *slime = NULL;
    static const uint32_t flat[3] = {0, 1, 4};
    CHECK_STATUS(cata_slime_new(4, positions, 1, flat, uv, NULL, NULL, &params, &slime),
                 CATA_ERR_MESH);
    static const double nowhere[12] = {0};
    CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, nowhere, NULL, NULL, &params, &slime),
                 CATA_ERR_MESH);
    CHECK_MENTIONS("face 0");
    static uint8_t walls[SIZE * SIZE];
    memset(walls, 1, sizeof walls);
    CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, uv, NULL, walls, &params, &slime),
                 CATA_ERR_ARGUMENT);
    params.size = 33;
    CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, uv, NULL, NULL, &params, &slime),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("size");
    CHECK_STATUS(cata_slime_new(4, NULL, 2, triangles, uv, NULL, NULL, &params, &slime),
                 CATA_ERR_NULL);
    CHECK(slime == NULL);
    params = small();
    slime = make(&params);
    int calls = 0;
    CHECK_STATUS(cata_slime_step(slime, 5, cancel, &calls), CATA_ERR_CANCELLED);
    uint32_t steps = 9;
    CHECK_STATUS(cata_slime_size(slime, NULL, NULL, NULL, &steps), CATA_OK);
    CHECK(calls == 1 && steps == 1);
    double coverage = 7;
    CHECK_STATUS(cata_slime_coverage(slime, 1, &coverage, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("species: 1 of 1");
    CHECK_STATUS(cata_slime_texture(slime, 1, texture), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_slime_texture(NULL, 0, texture), CATA_ERR_NULL);
    CHECK(coverage == 7);
    cata_slime_free(slime);
    cata_slime_free(NULL);
}

int main(void)
{
    test_threads();
    test_refusals();
    return report("test_slime");
}
