/* Mesh files through the C ABI: what is written is read again, in memory and on the disk;
 * attributes, names, notes; refusals. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

/* Two triangles of a square, with numbers that no float has. */
static const double corners[12] = {0.1, 0, 0, 1.1, 0, 0, 1.1, 1, 0, 0.1, 1, 1.0 / 3};
static const uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
/* A seam: the faces have other coordinates at the vertices that both have. */
static const double uv[12] = {0, 0, 0.5, 0, 0.5, 0.5, 0.5, 0.5, 1, 0.5, 1, 1};
static const double colors[16] = {0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1};

static cata_mesh_file *square(void)
{
    cata_mesh_file *file = NULL;
    CHECK_STATUS(cata_mesh_file_new(4, corners, 2, faces, &file), CATA_OK);
    return file;
}

static void check_square(const cata_mesh_file *file)
{
    size_t n_vertices = 0, n_faces = 0;
    double positions[12] = {0};
    uint32_t triangles[6] = {9};
    CHECK_STATUS(cata_mesh_file_size(file, &n_vertices, &n_faces), CATA_OK);
    CHECK(n_vertices == 4 && n_faces == 2);
    CHECK_STATUS(cata_mesh_file_get(file, positions, triangles), CATA_OK);
    CHECK(memcmp(positions, corners, sizeof corners) == 0);
    CHECK(memcmp(triangles, faces, sizeof faces) == 0);
}

static void check_attributes(const cata_mesh_file *file)
{
    double numbers[18];
    int32_t has_uv = 9, has_normals = 9, has_colors = 9;
    CHECK_STATUS(cata_mesh_file_has(file, &has_uv, &has_normals, &has_colors), CATA_OK);
    CHECK(has_uv == 1 && has_normals == 0 && has_colors == 1);
    CHECK_STATUS(cata_mesh_file_get_uv(file, numbers), CATA_OK);
    CHECK(memcmp(numbers, uv, sizeof uv) == 0);
    CHECK_STATUS(cata_mesh_file_get_colors(file, numbers), CATA_OK);
    CHECK(memcmp(numbers, colors, sizeof colors) == 0);
    CHECK_STATUS(cata_mesh_file_get_normals(file, numbers), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("normals: the mesh has none");
}

/* Every format gives the mesh back, those of single precision nearly. */
static void test_formats_in_memory(void)
{
    const int32_t formats[] = {CATA_MESH_OBJ, CATA_MESH_PLY, CATA_MESH_PLY_TEXT, CATA_MESH_OFF,
                               CATA_MESH_STL, CATA_MESH_STL_TEXT, CATA_MESH_GLB, CATA_MESH_GLTF,
                               CATA_MESH_VTK, CATA_MESH_VTK_TEXT, CATA_MESH_GIFTI, CATA_MESH_3MF};
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
        cata_mesh_file *file = square(), *again = NULL;
        cata_mesh_bytes *bytes = NULL;
        size_t size = 0, n_vertices = 0, n_faces = 0;
        double positions[12] = {0};
        CHECK_STATUS(cata_mesh_file_write_bytes(file, formats[i], &bytes), CATA_OK);
        CHECK_STATUS(cata_mesh_bytes_size(bytes, &size), CATA_OK);
        CHECK(size > 50);
        unsigned char *data = malloc(size);
        CHECK_STATUS(cata_mesh_bytes_get(bytes, data), CATA_OK);
        CHECK_STATUS(cata_mesh_file_read_bytes(size, data, formats[i], &again), CATA_OK);
        CHECK_STATUS(cata_mesh_file_size(again, &n_vertices, &n_faces), CATA_OK);
        CHECK(n_vertices == 4 && n_faces == 2);
        CHECK_STATUS(cata_mesh_file_get(again, positions, NULL), CATA_OK);
        /* Formats of triangles alone number the vertices anew, here as they were. */
        for (int k = 0; k < 12; k++) {
            CHECK(fabs(positions[k] - corners[k]) < 1e-6);
        }
        free(data);
        cata_mesh_bytes_free(bytes);
        cata_mesh_file_free(file);
        cata_mesh_file_free(again);
    }
}

static void test_attributes_stay(void)
{
    cata_mesh_file *file = square(), *again = NULL;
    cata_mesh_bytes *bytes = NULL;
    size_t size = 0, notes = 9, count = 9;
    char text[200];
    const char *const names[2] = {"left", "right"};
    const uint32_t of_faces[2] = {1, CATA_MESH_NO_NAME};
    uint32_t labels[2];
    CHECK_STATUS(cata_mesh_file_set_uv(file, uv), CATA_OK);
    CHECK_STATUS(cata_mesh_file_set_colors(file, colors), CATA_OK);
    CHECK_STATUS(cata_mesh_file_set_names(file, CATA_MESH_GROUPS, 2, names, of_faces), CATA_OK);
    check_attributes(file);
    CHECK_STATUS(cata_mesh_file_write_bytes(file, CATA_MESH_OBJ, &bytes), CATA_OK);
    CHECK_STATUS(cata_mesh_bytes_size(bytes, &size), CATA_OK);
    char *data = malloc(size);
    CHECK_STATUS(cata_mesh_bytes_get(bytes, data), CATA_OK);
    CHECK_STATUS(cata_mesh_file_read_bytes(size, data, CATA_MESH_OBJ, &again), CATA_OK);
    check_square(again);
    check_attributes(again);
    CHECK_STATUS(cata_mesh_file_get_names(again, CATA_MESH_GROUPS, labels), CATA_OK);
    CHECK_STATUS(cata_mesh_file_names(again, CATA_MESH_GROUPS, &count), CATA_OK);
    CHECK(count >= 1 && labels[0] < count && labels[1] == CATA_MESH_NO_NAME);
    CHECK_STATUS(cata_mesh_file_name(again, CATA_MESH_GROUPS, labels[0], sizeof text, text),
                 CATA_OK);
    CHECK(strcmp(text, "right") == 0);
    CHECK_STATUS(cata_mesh_file_name(again, CATA_MESH_GROUPS, labels[0], 4, text), CATA_OK);
    CHECK(strcmp(text, "rig") == 0);
    CHECK_STATUS(cata_mesh_file_names(again, CATA_MESH_MATERIALS, &count), CATA_OK);
    CHECK(count == 0);
    CHECK_STATUS(cata_mesh_file_get_names(again, CATA_MESH_MATERIALS, labels), CATA_OK);
    CHECK(labels[0] == CATA_MESH_NO_NAME && labels[1] == CATA_MESH_NO_NAME);
    free(data);
    cata_mesh_bytes_free(bytes);

    /* OFF has no place for some of them, which its notes say. */
    CHECK_STATUS(cata_mesh_file_notes(file, &notes, NULL), CATA_OK);
    CHECK(notes == 0);
    CHECK_STATUS(cata_mesh_file_write_bytes(file, CATA_MESH_OFF, &bytes), CATA_OK);
    cata_mesh_bytes_free(bytes);
    CHECK_STATUS(cata_mesh_file_notes(file, &notes, &count), CATA_OK);
    CHECK(notes == 1 && count == 0);
    CHECK_STATUS(cata_mesh_file_note(file, 0, sizeof text, text), CATA_OK);
    CHECK(strstr(text, "texture coordinates") != NULL);

    /* A face without coordinates has NaN, and attributes can be removed. */
    double numbers[12];
    memcpy(numbers, uv, sizeof uv);
    for (int k = 6; k < 12; k++) {
        numbers[k] = NAN;
    }
    CHECK_STATUS(cata_mesh_file_set_uv(file, numbers), CATA_OK);
    CHECK_STATUS(cata_mesh_file_get_uv(file, numbers), CATA_OK);
    CHECK(memcmp(numbers, uv, 6 * sizeof *uv) == 0 && isnan(numbers[6]) && isnan(numbers[11]));
    CHECK_STATUS(cata_mesh_file_set_uv(file, NULL), CATA_OK);
    CHECK_STATUS(cata_mesh_file_get_uv(file, numbers), CATA_ERR_ARGUMENT);
    double up[18] = {0}, normals[18];
    for (int k = 2; k < 18; k += 3) {
        up[k] = 2;
    }
    CHECK_STATUS(cata_mesh_file_set_normals(file, up), CATA_OK);
    CHECK_STATUS(cata_mesh_file_get_normals(file, normals), CATA_OK);
    CHECK(memcmp(normals, up, sizeof up) == 0);
    cata_mesh_file_free(file);
    cata_mesh_file_free(again);
}

/* Functions on vertices come with their names and values, and NULL leaves either out. */
static void test_functions_on_vertices(void)
{
    const char data[] = "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET POLYDATA\n"
                        "POINTS 4 double\n0 0 0 1 0 0 1 1 0 0 1 0\n"
                        "POLYGONS 2 8\n3 0 1 2\n3 0 2 3\n"
                        "POINT_DATA 4\nSCALARS heat float\nLOOKUP_TABLE default\n0 1 2 -0.5\n";
    const double heat[4] = {0, 1, 2, -0.5};
    cata_mesh_file *file = NULL;
    size_t count = 9;
    double values[4] = {9, 9, 9, 9};
    char name[20] = "";
    CHECK_STATUS(cata_mesh_file_read_bytes(sizeof data - 1, data, CATA_MESH_VTK, &file), CATA_OK);
    CHECK_STATUS(cata_mesh_file_scalars(file, &count), CATA_OK);
    CHECK(count == 1);
    CHECK_STATUS(cata_mesh_file_get_scalars(file, 0, sizeof name, name, NULL), CATA_OK);
    CHECK(strcmp(name, "heat") == 0 && values[0] == 9);
    CHECK_STATUS(cata_mesh_file_get_scalars(file, 0, 0, NULL, values), CATA_OK);
    CHECK(memcmp(values, heat, sizeof heat) == 0);
    CHECK_STATUS(cata_mesh_file_get_scalars(file, 1, sizeof name, name, values),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("index: must be less than 1");
    cata_mesh_file_free(file);
    file = square();
    CHECK_STATUS(cata_mesh_file_scalars(file, &count), CATA_OK);
    CHECK(count == 0);
    cata_mesh_file_free(file);
}

static void test_files(void)
{
    const char *const path = "test_mesh_files.ply";
    cata_mesh_file *file = square(), *again = NULL;
    cata_mesh_file_params params;
    CHECK_STATUS(cata_mesh_file_params_init(&params, sizeof params), CATA_OK);
    CHECK_STATUS(cata_mesh_file_write(file, path, NULL), CATA_OK);
    CHECK_STATUS(cata_mesh_file_read(path, NULL, &again), CATA_OK);
    check_square(again);
    cata_mesh_file_free(again);
    params.keep = 1;
    CHECK_STATUS(cata_mesh_file_write(file, path, &params), CATA_ERR_IO);
    CHECK_MENTIONS(path);
    params.keep = 0;
    params.format = CATA_MESH_PLY_TEXT;
    CHECK_STATUS(cata_mesh_file_write(file, path, &params), CATA_OK);
    CHECK_STATUS(cata_mesh_file_read(path, &params, &again), CATA_OK);
    check_square(again);
    cata_mesh_file_free(again);
    again = NULL;
    params.max_memory = 1;
    CHECK(cata_mesh_file_read(path, &params, &again) != CATA_OK && again == NULL);
    remove(path);
    CHECK_STATUS(cata_mesh_file_read(path, NULL, &again), CATA_ERR_IO);
    CHECK_STATUS(cata_mesh_file_write(file, "test_mesh_files.doc", NULL), CATA_ERR_IO);
    CHECK(again == NULL);
    cata_mesh_file_free(file);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

/* As a reader of files: C programs repair what other programs wrote. */
static void test_triangles_with_a_vertex_twice_are_left_out(void)
{
    const uint32_t found[9] = {0, 1, 1, 0, 1, 2, 0, 2, 3};
    cata_mesh_file *file = NULL;
    size_t notes = 0, collapsed = 0;
    CHECK_STATUS(cata_mesh_file_new(4, corners, 3, found, &file), CATA_OK);
    check_square(file);
    CHECK_STATUS(cata_mesh_file_notes(file, &notes, &collapsed), CATA_OK);
    CHECK(notes == 1 && collapsed == 1);
    cata_mesh_file_free(file);
}

static void test_refusals(void)
{
    cata_mesh_file *file = square(), *none = NULL;
    cata_mesh_bytes *bytes = NULL;
    const uint32_t wrong[3] = {0, 1, 4}, beyond[2] = {0, 1};
    const char *const names[1] = {"one"};
    double numbers[16] = {NAN};
    int calls = 0;
    cata_mesh_file_params params = {.struct_size = sizeof params, .format = 99};
    CHECK_STATUS(cata_mesh_file_new(4, corners, 1, wrong, &none), CATA_ERR_MESH);
    CHECK_MENTIONS("face 0");
    CHECK_STATUS(cata_mesh_file_read(NULL, NULL, &none), CATA_ERR_NULL);
    CHECK_STATUS(cata_mesh_file_read("", NULL, &none), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_mesh_file_read_bytes(4, "OFF\n", CATA_MESH_BY_NAME, &none),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("format");
    CHECK_STATUS(cata_mesh_file_read_bytes(4, "OFF\n", CATA_MESH_OFF, &none), CATA_ERR_IO);
    CHECK_STATUS(cata_mesh_file_write(file, "test_mesh_files.off", &params), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.format");
    params = (cata_mesh_file_params){.struct_size = sizeof params, .progress = cancel,
                                     .progress_user = &calls};
    CHECK_STATUS(cata_mesh_file_write(file, "test_mesh_files.off", &params), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    CHECK_STATUS(cata_mesh_file_write_bytes(file, 0, &bytes), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_mesh_file_set_uv(file, numbers), CATA_ERR_NON_FINITE);
    CHECK_STATUS(cata_mesh_file_set_colors(file, numbers), CATA_ERR_NON_FINITE);
    CHECK_STATUS(cata_mesh_file_set_names(file, 3, 1, names, beyond), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("kind");
    CHECK_STATUS(cata_mesh_file_set_names(file, CATA_MESH_OBJECTS, 1, names, beyond),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("of_faces: face 1");
    CHECK_STATUS(cata_mesh_file_note(file, 0, 0, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("index");
    CHECK_STATUS(cata_mesh_file_size(NULL, NULL, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("file: must not be NULL");
    CHECK(none == NULL && bytes == NULL);
    cata_mesh_file_free(file);
    cata_mesh_file_free(NULL);
    cata_mesh_bytes_free(NULL);
}

int main(void)
{
    test_formats_in_memory();
    test_attributes_stay();
    test_functions_on_vertices();
    test_files();
    test_triangles_with_a_vertex_twice_are_left_out();
    test_refusals();
    return report("test_mesh_files");
}
