/* Newton fractals through the C ABI: exact cases, refusals, outputs untouched, devices. */

#include <catamaran.h>

#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

static void test_points_at_roots(void)
{
    /* 1; the root -1/2 + (sqrt 3 / 2) i; 0, which goes nowhere. */
    const float points[9] = {1, 0, 0, -0.5F, 0.8660254F, 0, 0, 0, 0};
    cata_newton_params params;
    CHECK_STATUS(cata_newton_params_init(&params, sizeof params), CATA_OK);
    cata_newton *newton = NULL;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
    uint16_t roots[3] = {9, 9, 9};
    float convergence[3] = {9, 9, 9};
    CHECK_STATUS(cata_newton_points(newton, 3, points, roots, convergence), CATA_OK);
    CHECK(roots[0] == 0 && roots[1] == 4 && roots[2] == 0);
    CHECK(convergence[0] == -1 && convergence[1] < -0.9999F && convergence[2] == 32);
    uint8_t colors[9];
    CHECK_STATUS(cata_newton_colors(newton, 3, roots, convergence, colors), CATA_OK);
    CHECK(colors[0] > colors[6] && memcmp(colors, colors + 3, 3) != 0);
    CHECK_STATUS(cata_newton_points(newton, 0, NULL, NULL, NULL), CATA_OK);
    cata_newton_free(newton);
}

static void test_given_roots(void)
{
    const double given[4] = {2, 1, -2, 0};
    const float points[6] = {2, 1, 0, -2, 0, 0};
    cata_newton_params params = {.struct_size = sizeof params};
    params.roots = given;
    params.root_count = 2;
    params.gradient = CATA_NEWTON_SHADER;
    cata_newton *newton = NULL;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
    uint16_t roots[2];
    float convergence[2];
    CHECK_STATUS(cata_newton_points(newton, 2, points, roots, convergence), CATA_OK);
    CHECK(roots[0] == 0 && roots[1] == 3 && convergence[0] == 0 && convergence[1] == 0);
    cata_newton_free(newton);
    newton = NULL;
    params.power = 3;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.power");
    params.power = 0;
    params.roots = NULL;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_ERR_NULL);
    CHECK(newton == NULL);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    cata_newton *newton = NULL;
    cata_newton_params params = {.struct_size = sizeof params};
    params.power = 1;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_ERR_ARGUMENT);
    params.power = 2;
    params.gradient = 7;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_ERR_ARGUMENT);
    params.gradient = CATA_NEWTON_THESIS;
    CHECK_STATUS(cata_newton_new(&params, NULL), CATA_ERR_NULL);
    CHECK(newton == NULL);
    int calls = 0;
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
    uint16_t roots[4] = {7, 7, 7, 7};
    float convergence[4] = {7, 7, 7, 7};
    CHECK_STATUS(cata_newton_plane(newton, 2, 2, 0, 0, 1, roots, convergence), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    CHECK_STATUS(cata_newton_plane(newton, 2, 2, 0, 0, 0, roots, convergence), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("extent");
    CHECK_STATUS(cata_newton_plane(newton, 2, 2, 0, 0, 1, NULL, convergence), CATA_ERR_NULL);
    CHECK_STATUS(cata_newton_plane(NULL, 2, 2, 0, 0, 1, roots, convergence), CATA_ERR_NULL);
    CHECK_STATUS(cata_newton_set_w(newton, 1e300), CATA_ERR_ARGUMENT);
    const float far[3] = {0, 1e30F, 0};
    CHECK_STATUS(cata_newton_points(newton, 1, far, roots, convergence), CATA_ERR_NON_FINITE);
    CHECK(roots[0] == 7 && convergence[3] == 7);
    cata_newton_free(newton);
    cata_newton_free(NULL);
}

static void test_devices(void)
{
    cata_newton *newton = NULL;
    cata_newton_params params = {.struct_size = sizeof params};
    params.device = "no such device";
    size_t count = 77;
    int32_t kind = 77;
    char name[8] = "";
    if (!(cata_capabilities() & CATA_CAP_OPENCL)) {
        CHECK_STATUS(cata_newton_new(&params, &newton), CATA_ERR_UNSUPPORTED);
        CHECK_STATUS(cata_device_count(&count), CATA_ERR_UNSUPPORTED);
        CHECK_STATUS(cata_device_name(0, 0, NULL), CATA_ERR_UNSUPPORTED);
        CHECK_STATUS(cata_device_kind(0, &kind), CATA_ERR_UNSUPPORTED);
        CHECK(newton == NULL && count == 77 && kind == 77);
        return;
    }
    cata_status found = cata_device_count(&count);
    if (found == CATA_ERR_BACKEND && getenv("CATAMARAN_REQUIRE_OPENCL") == NULL) {
        CHECK_MENTIONS("apt install");
        puts("skipped: no OpenCL device");
        return;
    }
    CHECK_STATUS(found, CATA_OK);
    memset(name, 1, sizeof name);
    CHECK_STATUS(cata_device_name(0, sizeof name, name), CATA_OK);
    CHECK(count > 0 && name[0] != 0 && name[7] == 0);
    CHECK_STATUS(cata_device_name(count, sizeof name, name), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_device_kind(count, &kind), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("index");
    CHECK(kind == 77);
    CHECK_STATUS(cata_device_kind(0, &kind), CATA_OK);
    CHECK(CATA_DEVICE_CPU <= kind && kind <= CATA_DEVICE_OTHER);
    CHECK_STATUS(cata_device_kind(0, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_device_count(NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_device_name(0, sizeof name, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("no such device");
    params.device = "0";
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
    uint16_t roots[2] = {7, 7};
    float convergence[2];
    const float points[6] = {1, 0, 0, -0.5F, 0.8660254F, 0};
    CHECK_STATUS(cata_newton_points(newton, 2, points, roots, convergence), CATA_OK);
    CHECK(roots[0] == 0 && roots[1] == 4);
    cata_newton_free(newton);
    /* Progress and cancelling there. */
    int calls = 0;
    params.progress = cancel;
    params.progress_user = &calls;
    roots[0] = 7;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
    CHECK_STATUS(cata_newton_points(newton, 2, points, roots, convergence), CATA_ERR_CANCELLED);
    CHECK(calls == 1 && roots[0] == 7);
    cata_newton_free(newton);
}

/* A plane is its points, and threads change no byte. */
static void test_plane(void)
{
    enum { WIDE = 37, HIGH = 21, ALL = WIDE * HIGH };
    static float points[3 * ALL], first[ALL], here[ALL];
    static uint16_t roots[ALL], others[ALL];
    for (int i = 0; i < ALL; i++) {
        /* 2^-4 wide: without rounding. */
        points[3 * i] = (float)(i % WIDE - WIDE / 2) / 16;
        points[3 * i + 1] = (float)(HIGH / 2 - i / WIDE) / 16;
    }
    cata_newton_params params = {.struct_size = sizeof params, .threads = 1};
    cata_newton *newton = NULL;
    CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
    CHECK_STATUS(cata_newton_points(newton, ALL, points, roots, first), CATA_OK);
    cata_newton_free(newton);
    for (params.threads = 1; params.threads <= 4; params.threads *= 2) {
        CHECK_STATUS(cata_newton_new(&params, &newton), CATA_OK);
        CHECK_STATUS(cata_newton_plane(newton, WIDE, HIGH, 0, 0, WIDE / 16.0, others, here), CATA_OK);
        CHECK(memcmp(roots, others, sizeof roots) == 0 && memcmp(first, here, sizeof here) == 0);
        cata_newton_free(newton);
    }
}

int main(int argc, char **argv)
{
    const int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    test_points_at_roots();
    test_given_roots();
    test_refusals();
    test_plane();
    if (!quick) {
        test_devices(); /* whose drivers leak */
    }
    return report("test_newton");
}
