/* Repair through the C ABI: a soup of triangles becomes a cube, holes are filled, the report
 * counts what was done, attributes stay; refusals. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { F = 12 };

/* A cube: vertex v is at the bits of v. */
static const uint32_t cube[3 * F] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

static double place(uint32_t v, uint32_t axis)
{
    return (v >> axis) & 1;
}

/* The first `count` faces of the cube, no two of which share a vertex. */
static cata_mesh_file *soup(size_t count)
{
    double vertices[9 * F];
    uint32_t faces[3 * F];
    cata_mesh_file *file = NULL;
    for (size_t i = 0; i < 3 * count; i++) {
        faces[i] = (uint32_t)i;
        for (uint32_t axis = 0; axis < 3; axis++) {
            vertices[3 * i + axis] = place(cube[i], axis);
        }
    }
    CHECK_STATUS(cata_mesh_file_new(3 * count, vertices, count, faces, &file), CATA_OK);
    return file;
}

/* Six times the volume inside. */
static double volume(size_t n_faces, const double *p, const uint32_t *faces)
{
    double sum = 0;
    for (size_t f = 0; f < n_faces; f++) {
        const double *a = p + 3 * faces[3 * f], *b = p + 3 * faces[3 * f + 1];
        const double *c = p + 3 * faces[3 * f + 2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum;
}

static void check_cube(const cata_repair *repair)
{
    cata_mesh_file *file = NULL;
    size_t n_vertices = 0, n_faces = 0;
    double vertices[24];
    uint32_t faces[3 * F];
    CHECK_STATUS(cata_repair_file(repair, &file), CATA_OK);
    CHECK_STATUS(cata_mesh_file_size(file, &n_vertices, &n_faces), CATA_OK);
    CHECK(n_vertices == 8 && n_faces == F);
    if (n_vertices == 8 && n_faces == F) {
        CHECK_STATUS(cata_mesh_file_get(file, vertices, faces), CATA_OK);
        CHECK(fabs(volume(n_faces, vertices, faces) - 6) < 1e-12);
    }
    cata_mesh_file_free(file);
}

static void test_a_soup_becomes_a_cube(void)
{
    cata_mesh_file *file = soup(F);
    cata_repair *repair = NULL;
    cata_repair_params params;
    uint32_t of_vertices[3 * F];
    double uv[6 * F], again[6 * F];
    size_t steps = 0;
    int32_t changed = 9;
    for (int i = 0; i < 6 * F; i++) {
        uv[i] = i;
    }
    CHECK_STATUS(cata_mesh_file_set_uv(file, uv), CATA_OK);
    CHECK_STATUS(cata_repair_params_init(&params, sizeof params), CATA_OK);
    params.everything = 1;
    CHECK_STATUS(cata_repair_new(file, &params, &repair), CATA_OK);
    check_cube(repair);
    CHECK_STATUS(cata_repair_vertices(repair, of_vertices), CATA_OK);
    for (int i = 0; i < 3 * F; i++) {
        for (int j = 0; j < i; j++) {
            CHECK((cube[i] == cube[j]) == (of_vertices[i] == of_vertices[j]));
        }
        CHECK(of_vertices[i] < 8);
    }
    cata_mesh_file *found = NULL;
    CHECK_STATUS(cata_repair_file(repair, &found), CATA_OK);
    CHECK_STATUS(cata_mesh_file_get_uv(found, again), CATA_OK);
    CHECK(memcmp(uv, again, sizeof uv) == 0);
    cata_mesh_file_free(found);

    CHECK_STATUS(cata_repair_steps(repair, &steps, &changed), CATA_OK);
    CHECK(steps == 6 && changed == 1);
    const int32_t kinds[6] = {CATA_REPAIR_SEAMS, CATA_REPAIR_DUPLICATES, CATA_REPAIR_DEGENERATE,
                              CATA_REPAIR_COMPACTED, CATA_REPAIR_CUT, CATA_REPAIR_ORIENTED};
    for (size_t i = 0; i < 6; i++) {
        int32_t kind = 9;
        size_t vertices = 9, edges = 9, faces = 9, parts = 9, left = 9;
        char text[200] = {0};
        CHECK_STATUS(cata_repair_step(repair, i, &kind, &vertices, &edges, &faces, &parts, &left),
                     CATA_OK);
        CHECK(kind == kinds[i] && vertices == (i == 0 ? 28 : 0) && edges == 0 && faces == 0 &&
              parts == 0 && left == 0);
        CHECK_STATUS(cata_repair_step_text(repair, i, sizeof text, text), CATA_OK);
        CHECK(strlen(text) > 12);
        if (kind == CATA_REPAIR_SEAMS) {
            CHECK(strncmp(text, "weld        ", 12) == 0);
        }
    }
    CHECK_STATUS(cata_repair_step(repair, 6, NULL, NULL, NULL, NULL, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("step: must be less than 6 (steps), is 6");
    cata_repair_free(repair);

    /* No step: nothing changes. */
    CHECK_STATUS(cata_repair_new(file, NULL, &repair), CATA_OK);
    CHECK_STATUS(cata_repair_steps(repair, &steps, &changed), CATA_OK);
    CHECK(steps == 0 && changed == 0);
    CHECK_STATUS(cata_repair_vertices(repair, of_vertices), CATA_OK);
    CHECK(of_vertices[0] == 0 && of_vertices[3 * F - 1] == 3 * F - 1);
    cata_repair_free(repair);
    cata_mesh_file_free(file);
}

static void test_a_hole_is_filled(void)
{
    /* The last two faces are a side. */
    cata_mesh_file *file = soup(F - 2);
    cata_repair *repair = NULL;
    cata_repair_params params = {.struct_size = sizeof params, .weld = CATA_WELD_EXACT,
                                 .fill_holes = 3};
    int32_t kind = 9;
    size_t faces = 9, holes = 9, left = 9;
    CHECK_STATUS(cata_repair_new(file, &params, &repair), CATA_OK);
    CHECK_STATUS(cata_repair_step(repair, 1, &kind, NULL, NULL, &faces, &holes, &left), CATA_OK);
    CHECK(kind == CATA_REPAIR_HOLES && faces == 0 && holes == 0 && left == 1);
    cata_repair_free(repair);
    params.fill_holes = 4;
    CHECK_STATUS(cata_repair_new(file, &params, &repair), CATA_OK);
    CHECK_STATUS(cata_repair_step(repair, 1, &kind, NULL, NULL, &faces, &holes, &left), CATA_OK);
    CHECK(kind == CATA_REPAIR_HOLES && faces == 2 && holes == 1 && left == 0);
    check_cube(repair);
    cata_repair_free(repair);
    cata_mesh_file_free(file);
}

static void test_needed(void)
{
    double vertices[24];
    uint32_t twice[3 * (F + 1)];
    int32_t needed = 9;
    char text[100];
    for (uint32_t v = 0; v < 8; v++) {
        for (uint32_t axis = 0; axis < 3; axis++) {
            vertices[3 * v + axis] = place(v, axis);
        }
    }
    memcpy(twice, cube, sizeof cube);
    memcpy(twice + 3 * F, cube, 3 * sizeof *cube);
    CHECK_STATUS(cata_repair_needed(8, vertices, F, twice, &needed, sizeof text, text), CATA_OK);
    CHECK(needed == 0 && text[0] == 0);
    CHECK_STATUS(cata_repair_needed(8, vertices, F + 1, twice, &needed, sizeof text, text),
                 CATA_OK);
    CHECK(needed == 1 && strstr(text, "face 12") != NULL);
    CHECK_STATUS(cata_repair_needed(8, vertices, F + 1, twice, &needed, 0, NULL), CATA_OK);
    CHECK(needed == 1);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    cata_mesh_file *file = soup(F);
    cata_repair *none = NULL;
    int calls = 0;
    cata_repair_params params = {.struct_size = sizeof params, .weld = 4};
    CHECK_STATUS(cata_repair_new(file, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.weld");
    params.weld = CATA_WELD_WITHIN;
    params.tolerance = -1;
    CHECK_STATUS(cata_repair_new(file, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("tolerance");
    params.weld = 0;
    params.drop_specks = 2;
    CHECK_STATUS(cata_repair_new(file, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("drop_specks");
    params.drop_specks = 0;
    params.orient = 2;
    CHECK_STATUS(cata_repair_new(file, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.orient: must be 0 or 1, is 2");
    params = (cata_repair_params){.struct_size = sizeof params, .progress = cancel,
                                  .progress_user = &calls};
    CHECK_STATUS(cata_repair_new(file, &params, &none), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    CHECK_STATUS(cata_repair_new(NULL, NULL, &none), CATA_ERR_NULL);
    CHECK_MENTIONS("file: must not be NULL");
    CHECK_STATUS(cata_repair_file(NULL, NULL), CATA_ERR_NULL);
    CHECK(none == NULL);
    cata_repair_free(NULL);
    cata_mesh_file_free(file);
}

int main(void)
{
    test_a_soup_becomes_a_cube();
    test_a_hole_is_filled();
    test_needed();
    test_refusals();
    return report("test_repair");
}
