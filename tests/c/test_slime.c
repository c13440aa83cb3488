/* Slime moulds through the C ABI: the same bytes for any threads and on devices, cancelling, exact evaporation, refusals, outputs untouched. */

#include <catamaran.h>

#include <stdlib.h>
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
        CHECK_STATUS(cata_slime_step(slime, 20), CATA_OK);
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

/* Three times five steps, each time cancelled after the first. */
static void broken_run(cata_slime_params params, float *pheromone, double *covered)
{
    int calls = 0;
    params.progress = cancel;
    params.progress_user = &calls;
    cata_slime *slime = make(&params);
    for (uint32_t done = 1; done <= 3; done++) {
        uint32_t steps = 0;
        CHECK_STATUS(cata_slime_step(slime, 5), CATA_ERR_CANCELLED);
        CHECK_STATUS(cata_slime_size(slime, NULL, NULL, NULL, &steps), CATA_OK);
        CHECK(calls == (int)done && steps == done);
    }
    CHECK_STATUS(cata_slime_step(slime, 0), CATA_OK);
    for (size_t s = 0; s < 2; s++) {
        CHECK_STATUS(cata_slime_texture(slime, s, pheromone + s * SIZE * SIZE), CATA_OK);
        CHECK_STATUS(cata_slime_coverage(slime, s, covered + 2 * s, covered + 2 * s + 1), CATA_OK);
    }
    cata_slime_free(slime);
}

/* What the processor computes, to the byte where the device is one. */
static void test_devices(void)
{
    cata_slime_params params = small();
    cata_slime *slime = NULL;
    params.species = 2;
    params.device = "no such device";
    size_t count = 77;
    int32_t kind = -1;
    if (!(cata_capabilities() & CATA_CAP_OPENCL)) {
        CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, uv, NULL, NULL, &params, &slime),
                     CATA_ERR_UNSUPPORTED);
        CHECK(slime == NULL);
        return;
    }
    const cata_status found = cata_device_count(&count);
    if (found == CATA_ERR_BACKEND && getenv("CATAMARAN_REQUIRE_OPENCL") == NULL) {
        puts("skipped: no OpenCL device");
        return;
    }
    CHECK_STATUS(found, CATA_OK);
    CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, uv, NULL, NULL, &params, &slime),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("no such device");
    CHECK(slime == NULL);
    static float here[2 * SIZE * SIZE], there[2 * SIZE * SIZE];
    double covered_here[4], covered_there[4];
    params.device = NULL;
    broken_run(params, here, covered_here);
    params.device = "0";
    broken_run(params, there, covered_there);
    CHECK_STATUS(cata_device_kind(0, &kind), CATA_OK);
    if (kind == CATA_DEVICE_CPU) {
        CHECK(memcmp(here, there, sizeof here) == 0);
        CHECK(memcmp(covered_here, covered_there, sizeof covered_here) == 0);
    }
    slime = make(&params);
    other[0] = 7;
    CHECK_STATUS(cata_slime_step(slime, 20), CATA_OK);
    CHECK_STATUS(cata_slime_texture(slime, 2, other), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_slime_coverage(slime, 2, NULL, NULL), CATA_ERR_ARGUMENT);
    CHECK(other[0] == 7);
    CHECK_STATUS(cata_slime_texture(slime, 1, other), CATA_OK);
    uint32_t steps = 0;
    CHECK_STATUS(cata_slime_size(slime, NULL, NULL, NULL, &steps), CATA_OK);
    CHECK(other[0] != 7 && steps == 20);
    cata_slime_free(slime);
}

/* Each enumeration changes what happens, and has no other values. */
static void test_kinds(void)
{
    static float kinds[4][SIZE * SIZE];
    for (int i = 0; i < 4; i++) {
        cata_slime_params params = small();
        params.vision_distance = 5;
        params.turns = i == 1 ? CATA_SLIME_TURNS_EVEN : CATA_SLIME_TURNS_RANDOM;
        params.blur = i == 2 ? CATA_SLIME_BLUR_TEXTURE : CATA_SLIME_BLUR_SURFACE;
        params.lengths = i == 3 ? CATA_SLIME_LENGTHS_TEXTURE : CATA_SLIME_LENGTHS_SURFACE;
        cata_slime *slime = NULL;
        /* In the atlas, where there are seams and another scale. */
        CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, NULL, NULL, NULL, &params, &slime), CATA_OK);
        CHECK_STATUS(cata_slime_step(slime, 9), CATA_OK);
        CHECK_STATUS(cata_slime_texture(slime, 0, kinds[i]), CATA_OK);
        CHECK(i == 0 || memcmp(kinds[0], kinds[i], sizeof kinds[0]) != 0);
        cata_slime_free(slime);
    }
    cata_slime *slime = NULL;
    cata_slime_params params = small();
    params.blur = 2;
    CHECK_STATUS(cata_slime_new(4, positions, 2, triangles, uv, NULL, NULL, &params, &slime), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.blur: must be a CATA_SLIME_BLUR_* value");
    CHECK(slime == NULL);
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
    CHECK_STATUS(cata_slime_step(NULL, 1), CATA_ERR_NULL);
    double coverage = 7;
    CHECK_STATUS(cata_slime_coverage(slime, 1, &coverage, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("species: must be less than 1 (species), is 1");
    CHECK_STATUS(cata_slime_texture(slime, 1, texture), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_slime_texture(NULL, 0, texture), CATA_ERR_NULL);
    CHECK(coverage == 7);
    cata_slime_free(slime);
    cata_slime_free(NULL);
}

int main(int argc, char **argv)
{
    const int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    test_threads();
    test_kinds();
    if (!quick) {
        test_devices(); /* whose drivers leak */
    }
    test_refusals();
    return report("test_slime");
}
