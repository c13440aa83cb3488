/* Pointers that must not be NULL, and sizes beyond the address space: every function of geometry
 * and of Cholesky factorizations names the argument, and leaves outputs as they are. */

#include <catamaran.h>

#include <stdint.h>
#include <string.h>

#include "check.h"
#include "meshes.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

#define NEEDS(name, call)                                \
    do {                                                 \
        CHECK_STATUS(call, CATA_ERR_NULL);               \
        CHECK_MENTIONS(name ": must not be NULL");       \
    } while (0)

#define TOO_LARGE(name, call)                            \
    do {                                                 \
        CHECK_STATUS(call, CATA_ERR_SHAPE);              \
        CHECK_MENTIONS(name ": ");                       \
    } while (0)

enum { SIDE = 5, V = SIDE * SIDE, F = 2 * (SIDE - 1) * (SIDE - 1) };

static double v[3 * V], x[CATA_SHOT_BINS * V];
static uint32_t f[3 * F], u[9 * F];
static uint8_t inside[F];
static size_t n, places[9 * F];
static int32_t number;
static char text[100];
/* As many doubles as no address space has. */
static const size_t most = SIZE_MAX / 8;

static void test_files(void)
{
    cata_mesh_file *file = NULL, *made = NULL;
    cata_mesh_bytes *bytes = NULL, *written = NULL;
    const char *const names[1] = {"one"}, *const none[1] = {NULL};
    NEEDS("vertices", cata_mesh_file_new(V, NULL, F, f, &made));
    NEEDS("faces", cata_mesh_file_new(V, v, F, NULL, &made));
    NEEDS("file", cata_mesh_file_new(V, v, F, f, NULL));
    TOO_LARGE("vertices", cata_mesh_file_new(most, v, F, f, &made));
    TOO_LARGE("faces", cata_mesh_file_new(V, v, most, f, &made));
    CHECK_STATUS(cata_mesh_file_new(V, v, F, f, &file), CATA_OK);
    CHECK_STATUS(cata_mesh_file_write_bytes(file, CATA_MESH_OFF, &bytes), CATA_OK);
    NEEDS("params", cata_mesh_file_params_init(NULL, sizeof(cata_mesh_file_params)));
    NEEDS("path", cata_mesh_file_read(NULL, NULL, &made));
    NEEDS("file", cata_mesh_file_read("test_nulls.off", NULL, NULL));
    NEEDS("bytes", cata_mesh_file_read_bytes(4, NULL, CATA_MESH_OFF, &made));
    NEEDS("file", cata_mesh_file_read_bytes(4, "OFF\n", CATA_MESH_OFF, NULL));
    NEEDS("file", cata_mesh_file_write(NULL, "test_nulls.off", NULL));
    NEEDS("path", cata_mesh_file_write(file, NULL, NULL));
    NEEDS("file", cata_mesh_file_write_bytes(NULL, CATA_MESH_OFF, &written));
    NEEDS("bytes", cata_mesh_file_write_bytes(file, CATA_MESH_OFF, NULL));
    NEEDS("file", cata_mesh_file_size(NULL, &n, NULL));
    NEEDS("file", cata_mesh_file_get(NULL, x, u));
    NEEDS("file", cata_mesh_file_notes(NULL, NULL, NULL));
    NEEDS("file", cata_mesh_file_note(NULL, 0, sizeof text, text));
    NEEDS("text", cata_mesh_file_note(file, 0, 1, NULL));
    NEEDS("bytes", cata_mesh_bytes_size(NULL, &n));
    NEEDS("size", cata_mesh_bytes_size(bytes, NULL));
    NEEDS("bytes", cata_mesh_bytes_get(NULL, x));
    NEEDS("to", cata_mesh_bytes_get(bytes, NULL));
    NEEDS("file", cata_mesh_file_has(NULL, NULL, NULL, NULL));
    NEEDS("file", cata_mesh_file_get_uv(NULL, x));
    NEEDS("uv", cata_mesh_file_get_uv(file, NULL));
    NEEDS("file", cata_mesh_file_get_normals(NULL, x));
    NEEDS("normals", cata_mesh_file_get_normals(file, NULL));
    NEEDS("file", cata_mesh_file_get_colors(NULL, x));
    NEEDS("colors", cata_mesh_file_get_colors(file, NULL));
    NEEDS("file", cata_mesh_file_set_uv(NULL, x));
    NEEDS("file", cata_mesh_file_set_normals(NULL, x));
    NEEDS("file", cata_mesh_file_set_colors(NULL, x));
    NEEDS("file", cata_mesh_file_names(NULL, CATA_MESH_GROUPS, &n));
    NEEDS("count", cata_mesh_file_names(file, CATA_MESH_GROUPS, NULL));
    NEEDS("file", cata_mesh_file_name(NULL, CATA_MESH_GROUPS, 0, sizeof text, text));
    NEEDS("name", cata_mesh_file_name(file, CATA_MESH_GROUPS, 0, 1, NULL));
    NEEDS("file", cata_mesh_file_get_names(NULL, CATA_MESH_GROUPS, u));
    NEEDS("of_faces", cata_mesh_file_get_names(file, CATA_MESH_GROUPS, NULL));
    NEEDS("file", cata_mesh_file_scalars(NULL, &n));
    NEEDS("count", cata_mesh_file_scalars(file, NULL));
    NEEDS("file", cata_mesh_file_get_scalars(NULL, 0, sizeof text, text, x));
    NEEDS("file", cata_mesh_file_set_names(NULL, CATA_MESH_GROUPS, 1, names, u));
    NEEDS("names", cata_mesh_file_set_names(file, CATA_MESH_GROUPS, 1, NULL, u));
    NEEDS("names", cata_mesh_file_set_names(file, CATA_MESH_GROUPS, 1, none, u));
    NEEDS("of_faces", cata_mesh_file_set_names(file, CATA_MESH_GROUPS, 1, names, NULL));
    CHECK(made == NULL && written == NULL);
    cata_mesh_bytes_free(bytes);
    cata_mesh_file_free(file);
}

static void test_repair(void)
{
    cata_mesh_file *file = NULL, *made = NULL;
    cata_repair *repair = NULL, *none = NULL;
    CHECK_STATUS(cata_mesh_file_new(V, v, F, f, &file), CATA_OK);
    CHECK_STATUS(cata_repair_new(file, NULL, &repair), CATA_OK);
    NEEDS("params", cata_repair_params_init(NULL, sizeof(cata_repair_params)));
    NEEDS("file", cata_repair_new(NULL, NULL, &none));
    NEEDS("repair", cata_repair_new(file, NULL, NULL));
    NEEDS("repair", cata_repair_file(NULL, &made));
    NEEDS("file", cata_repair_file(repair, NULL));
    NEEDS("repair", cata_repair_vertices(NULL, u));
    NEEDS("vertices", cata_repair_vertices(repair, NULL));
    NEEDS("repair", cata_repair_steps(NULL, NULL, NULL));
    NEEDS("repair", cata_repair_step(NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL));
    NEEDS("repair", cata_repair_step_text(NULL, 0, sizeof text, text));
    NEEDS("vertices", cata_repair_needed(V, NULL, F, f, &number, sizeof text, text));
    NEEDS("needed", cata_repair_needed(V, v, F, f, NULL, sizeof text, text));
    TOO_LARGE("faces", cata_repair_needed(V, v, most, f, &number, sizeof text, text));
    CHECK(made == NULL && none == NULL);
    cata_repair_free(repair);
    cata_mesh_file_free(file);
}

static void test_laplacians(void)
{
    cata_laplacian *laplacian = NULL, *none = NULL;
    CHECK_STATUS(cata_laplacian_new(V, v, F, f, 0, NULL, NULL, &laplacian), CATA_OK);
    NEEDS("vertices", cata_laplacian_new(V, NULL, F, f, 0, NULL, NULL, &none));
    NEEDS("held", cata_laplacian_new(V, v, F, f, 1, NULL, NULL, &none));
    NEEDS("laplacian", cata_laplacian_new(V, v, F, f, 0, NULL, NULL, NULL));
    TOO_LARGE("held", cata_laplacian_new(V, v, F, f, most * 4, u, NULL, &none));
    NEEDS("points", cata_cloud_laplacian(V, NULL, 0, NULL, &none));
    NEEDS("laplacian", cata_cloud_laplacian(V, v, 0, NULL, NULL));
    TOO_LARGE("points", cata_cloud_laplacian(most, v, 0, NULL, &none));
    NEEDS("laplacian", cata_laplacian_size(NULL, NULL, NULL, NULL));
    NEEDS("laplacian", cata_laplacian_get(NULL, u, places, places, x));
    NEEDS("laplacian", cata_laplacian_masses(NULL, x));
    NEEDS("masses", cata_laplacian_masses(laplacian, NULL));
    NEEDS("faces", cata_laplacian_gradient(V, v, F, NULL, places, NULL, x));
    NEEDS("vertices", cata_laplacian_divergence(V, NULL, F, f, places, NULL, x));
    NEEDS("vertices", cata_laplacian_areas(V, NULL, F, f, x));
    NEEDS("areas", cata_laplacian_areas(V, v, F, f, NULL));
    CHECK(none == NULL);
    cata_laplacian_free(laplacian);
}

static void test_distances(void)
{
    cata_heat *heat = NULL, *none = NULL;
    cata_path *path = NULL, *other = NULL;
    const uint32_t source = 0;
    CHECK_STATUS(cata_heat_new(V, v, F, f, NULL, &heat), CATA_OK);
    CHECK_STATUS(cata_distance_path(V, v, F, f, 0, 7, 0, NULL, &path), CATA_OK);
    NEEDS("params", cata_distance_params_init(NULL, sizeof(cata_distance_params)));
    NEEDS("vertices", cata_heat_new(V, NULL, F, f, NULL, &none));
    NEEDS("heat", cata_heat_new(V, v, F, f, NULL, NULL));
    NEEDS("heat", cata_heat_distances(NULL, 1, &source, x));
    NEEDS("sources", cata_heat_distances(heat, 1, NULL, x));
    NEEDS("distances", cata_heat_distances(heat, 1, &source, NULL));
    TOO_LARGE("sources", cata_heat_distances(heat, most * 4, &source, x));
    NEEDS("faces", cata_distance_edges(V, v, F, NULL, 1, &source, x, NULL, NULL, NULL));
    NEEDS("sources", cata_distance_edges(V, v, F, f, 1, NULL, x, NULL, NULL, NULL));
    NEEDS("distances", cata_distance_edges(V, v, F, f, 1, &source, NULL, NULL, NULL, NULL));
    NEEDS("sources", cata_distance_exact(V, v, F, f, 1, NULL, NULL, x, NULL));
    NEEDS("distances", cata_distance_exact(V, v, F, f, 1, &source, NULL, NULL, NULL));
    NEEDS("through", cata_distance_path_exact(V, v, F, f, 2, NULL, NULL, NULL, &other));
    NEEDS("path", cata_distance_path_exact(V, v, F, f, 1, &source, NULL, NULL, NULL));
    NEEDS("direction", cata_distance_trace(V, v, F, f, 0, NULL, NULL, 1, NULL, &other, NULL, NULL));
    NEEDS("path", cata_distance_trace(V, v, F, f, 0, NULL, v, 1, NULL, NULL, NULL, NULL));
    NEEDS("path", cata_path_places(NULL, NULL, NULL));
    NEEDS("vertices", cata_distance_path(V, NULL, F, f, 0, 1, 0, NULL, &other));
    NEEDS("path", cata_distance_path(V, v, F, f, 0, 1, 0, NULL, NULL));
    NEEDS("path", cata_path_size(NULL, NULL, NULL, NULL));
    NEEDS("path", cata_path_get(NULL, u, x));
    CHECK(none == NULL && other == NULL);
    cata_path_free(path);
    cata_heat_free(heat);
}

static void test_regions(void)
{
    cata_drawing *drawing = NULL, *none = NULL;
    cata_drawn *drawn = NULL, *other = NULL;
    cata_part *part = NULL;
    const uint32_t samples[4] = {6, 8, 18, 16}, along[2] = {6, 7};
    CHECK_STATUS(cata_drawing_new(V, v, F, f, &drawing), CATA_OK);
    CHECK_STATUS(cata_drawing_add(drawing, 4, samples, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_drawing_inscribe(drawing, 0, &drawn), CATA_OK);
    NEEDS("vertices", cata_drawing_new(V, NULL, F, f, &none));
    NEEDS("drawing", cata_drawing_new(V, v, F, f, NULL));
    NEEDS("drawing", cata_drawing_add(NULL, 4, samples, NULL, NULL));
    NEEDS("samples", cata_drawing_add(drawing, 4, NULL, NULL, NULL));
    TOO_LARGE("samples", cata_drawing_add(drawing, most * 4, samples, NULL, NULL));
    NEEDS("drawing", cata_drawing_inscribe(NULL, 0, &other));
    NEEDS("drawn", cata_drawing_inscribe(drawing, 0, NULL));
    NEEDS("drawn", cata_drawn_size(NULL, NULL, NULL, NULL));
    NEEDS("drawn", cata_drawn_get(NULL, x, u, NULL, NULL, NULL));
    NEEDS("drawn", cata_drawn_edges(NULL, 0, 0, NULL, &n));
    NEEDS("count", cata_drawn_edges(drawn, 0, 0, NULL, NULL));
    TOO_LARGE("along", cata_drawn_edges(drawn, 0, most, u, &n));
    NEEDS("drawn", cata_drawn_shares(NULL, inside, x));
    NEEDS("inside", cata_drawn_shares(drawn, NULL, x));
    NEEDS("vertices", cata_region_enclosed(V, NULL, F, f, 1, along, CATA_SIDE_SMALL, 0, NULL,
                                           inside));
    NEEDS("along", cata_region_enclosed(V, v, F, f, 1, NULL, CATA_SIDE_SMALL, 0, NULL, inside));
    NEEDS("seeds", cata_region_enclosed(V, v, F, f, 1, along, CATA_SIDE_SEEDS, 1, NULL, inside));
    NEEDS("inside", cata_region_enclosed(V, v, F, f, 1, along, CATA_SIDE_SMALL, 0, NULL, NULL));
    TOO_LARGE("along", cata_region_enclosed(V, v, F, f, most, along, CATA_SIDE_SMALL, 0, NULL,
                                            inside));
    NEEDS("first", cata_region_combine(CATA_REGION_UNION, F, NULL, inside, (uint8_t *)u));
    NEEDS("second", cata_region_combine(CATA_REGION_UNION, F, inside, NULL, (uint8_t *)u));
    NEEDS("result", cata_region_combine(CATA_REGION_UNION, F, inside, inside, NULL));
    NEEDS("inside", cata_region_area(V, v, F, f, NULL, x));
    NEEDS("area", cata_region_area(V, v, F, f, inside, NULL));
    NEEDS("inside", cata_region_boundary(V, v, F, f, NULL, 0, NULL, &n));
    NEEDS("count", cata_region_boundary(V, v, F, f, inside, 0, NULL, NULL));
    TOO_LARGE("edges", cata_region_boundary(V, v, F, f, inside, most, u, &n));
    NEEDS("inside", cata_region_part(V, v, F, f, NULL, &part));
    NEEDS("part", cata_region_part(V, v, F, f, inside, NULL));
    NEEDS("along", cata_region_cut(V, v, F, f, 1, NULL, &part));
    NEEDS("part", cata_region_cut(V, v, F, f, 1, along, NULL));
    TOO_LARGE("along", cata_region_cut(V, v, F, f, most, along, &part));
    NEEDS("part", cata_part_size(NULL, NULL, NULL));
    NEEDS("part", cata_part_get(NULL, x, u, NULL, NULL));
    CHECK(none == NULL && other == NULL && part == NULL);
    cata_drawn_free(drawn);
    cata_drawing_free(drawing);
}

static void test_surfaces(void)
{
    const size_t counts[3] = {1, 1, 1};
    const double origin[3] = {0, 0, 0}, step[3] = {1, 1, 1};
    const float value = 1;
    cata_mesh_file *file = NULL;
    NEEDS("params", cata_mesh_params_init(NULL, sizeof(cata_mesh_params)));
    NEEDS("vertices", cata_mesh_edges(V, NULL, F, f, 0, NULL, NULL, &n));
    NEEDS("count", cata_mesh_edges(V, v, F, f, 0, NULL, NULL, NULL));
    TOO_LARGE("edges", cata_mesh_edges(V, v, F, f, most, u, NULL, &n));
    NEEDS("faces", cata_mesh_components(V, v, F, NULL, u, NULL, &n));
    NEEDS("count", cata_mesh_components(V, v, F, f, u, u + V, NULL));
    NEEDS("genus", cata_mesh_genus(V, v, F, f, NULL, &number));
    NEEDS("total", cata_mesh_boundary_loops(V, v, F, f, 0, NULL, NULL, NULL, &n));
    NEEDS("count", cata_mesh_boundary_loops(V, v, F, f, 0, NULL, NULL, &n, NULL));
    NEEDS("faces", cata_mesh_measures(V, v, F, NULL, x, NULL, NULL, NULL, NULL, NULL));
    NEEDS("faces", cata_mesh_quality(V, v, F, NULL, x, NULL, NULL, NULL, NULL, NULL, NULL, NULL));
    NEEDS("other: vertices",
          cata_mesh_compare(V, v, F, f, V, NULL, F, f, x, NULL, NULL, NULL, NULL));
    NEEDS("counts", cata_mesh_isosurface(NULL, origin, step, &value, 0, 0, NULL, &file));
    NEEDS("origin", cata_mesh_isosurface(counts, NULL, step, &value, 0, 0, NULL, &file));
    NEEDS("step", cata_mesh_isosurface(counts, origin, NULL, &value, 0, 0, NULL, &file));
    NEEDS("values", cata_mesh_isosurface(counts, origin, step, NULL, 0, 0, NULL, &file));
    NEEDS("file", cata_mesh_isosurface(counts, origin, step, &value, 0, 0, NULL, NULL));
    NEEDS("labels", cata_mesh_label_surface(counts, origin, step, NULL, 1, 0, NULL, &file));
    NEEDS("name", cata_mesh_shape(NULL, 0, NULL, 0, NULL, &file));
    CHECK_STATUS(cata_mesh_shape("gr\xef" "d", 0, NULL, 0, NULL, &file), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("name: must be in UTF-8");
    NEEDS("counts", cata_mesh_shape("grid", 2, NULL, 0, NULL, &file));
    NEEDS("sizes", cata_mesh_shape("figure", 1, counts, 1, NULL, &file));
    NEEDS("file", cata_mesh_shape("grid", 2, counts, 0, NULL, NULL));
    NEEDS("text", cata_ata_plan_f64(1, 1, NULL, 1, NULL));
    NEEDS("decimation", cata_decimation_eigs(NULL, 1, x, x + 1, V, NULL, NULL, NULL));
    CHECK(file == NULL);
}

static void test_descriptors(void)
{
    const double values[2] = {0, 1}, vectors[6] = {1, 1, 1, 1, 0, -1}, one = 1;
    const int32_t c = CATA_COL_MAJOR;
    NEEDS("params", cata_descriptor_params_init(NULL, sizeof(cata_descriptor_params)));
    NEEDS("params", cata_shape_params_init(NULL, sizeof(cata_shape_params)));
    NEEDS("eigenvalues",
          cata_descriptor_heat(c, 3, 2, NULL, vectors, 3, 1, &one, 0, x, 3, NULL));
    NEEDS("eigenvectors",
          cata_descriptor_heat(c, 3, 2, values, NULL, 3, 1, &one, 0, x, 3, NULL));
    NEEDS("times", cata_descriptor_heat(c, 3, 2, values, vectors, 3, 1, NULL, 0, x, 3, NULL));
    NEEDS("signature",
          cata_descriptor_heat(c, 3, 2, values, vectors, 3, 1, &one, 0, NULL, 3, NULL));
    TOO_LARGE("ldsignature",
              cata_descriptor_heat(c, 3, 2, values, vectors, 3, 1, &one, 0, x, 2, NULL));
    NEEDS("eigenvalues", cata_descriptor_heat_times(2, NULL, 1, x));
    NEEDS("times", cata_descriptor_heat_times(2, values, 1, NULL));
    NEEDS("eigenvalues", cata_descriptor_heat_kernel(c, 3, 2, NULL, vectors, 3, 0, 1, x));
    NEEDS("heat", cata_descriptor_heat_kernel(c, 3, 2, values, vectors, 3, 0, 1, NULL));
    TOO_LARGE("ldv", cata_descriptor_heat_kernel(c, 3, 2, values, vectors, 2, 0, 1, x));
    CHECK_MENTIONS("ldv: must be at least 3 (rows of eigenvectors), is 2");
    NEEDS("energies", cata_descriptor_wave(c, 3, 2, values, vectors, 3, 1, NULL, 1, x, 3, NULL));
    NEEDS("signature",
          cata_descriptor_wave(c, 3, 2, values, vectors, 3, 1, &one, 1, NULL, 3, NULL));
    TOO_LARGE("ldsignature",
              cata_descriptor_wave(c, 3, 2, values, vectors, 3, 1, &one, 1, x, 0, NULL));
    NEEDS("eigenvalues", cata_descriptor_wave_scales(2, NULL, 1, x, x + 1));
    NEEDS("energies", cata_descriptor_wave_scales(2, values, 1, NULL, x));
    NEEDS("sigma", cata_descriptor_wave_scales(2, values, 1, x, NULL));
    NEEDS("count", cata_descriptor_points(c, 3, 2, values, vectors, 3, NULL, x, 3));
    NEEDS("signature", cata_descriptor_points(c, 3, 2, values, vectors, 3, &n, NULL, 3));
    TOO_LARGE("ldsignature", cata_descriptor_points(c, 3, 2, values, vectors, 3, &n, x, 1));
    NEEDS("vertices",
          cata_descriptor_shot(V, NULL, F, f, 1, c, x, V, NULL));
    NEEDS("signature", cata_descriptor_shot(V, v, F, f, 1, c, NULL, V, NULL));
    TOO_LARGE("ldsignature", cata_descriptor_shot(V, v, F, f, 1, c, x, V - 1, NULL));
    NEEDS("f", cata_descriptor_rings(V, v, F, f, 1, 2, c, 1, NULL, V, x, V, NULL));
    NEEDS("signature", cata_descriptor_rings(V, v, F, f, 1, 2, c, 0, NULL, V, NULL, V, NULL));
    TOO_LARGE("signature",
              cata_descriptor_rings(V, v, F, f, 1, SIZE_MAX, c, 0, NULL, V, x, V, NULL));
    NEEDS("frequencies", cata_filter_gains(CATA_RESPONSE_HEAT, 1, 0, 1, NULL, x, NULL));
    NEEDS("gains", cata_filter_gains(CATA_RESPONSE_HEAT, 1, 0, 1, &one, NULL, NULL));
    TOO_LARGE("frequencies", cata_filter_gains(CATA_RESPONSE_HEAT, 1, 0, most, &one, x, NULL));
    NEEDS("vertices",
          cata_shape_from_spectrum(V, NULL, F, f, 1, &one, x, NULL, NULL, NULL, NULL));
    NEEDS("eigenvalues",
          cata_shape_from_spectrum(V, v, F, f, 1, NULL, x, NULL, NULL, NULL, NULL));
    NEEDS("positions",
          cata_shape_from_spectrum(V, v, F, f, 1, &one, NULL, NULL, NULL, NULL, NULL));
}

static void test_sparse(void)
{
    const size_t starts[3] = {0, 2, 4}, columns[4] = {0, 1, 0, 1}, row = 1;
    const double entries[4] = {2, -1, -1, 2}, b[2] = {1, 1};
    const int32_t c = CATA_COL_MAJOR;
    cata_cholesky *cholesky = NULL, *none = NULL;
    NEEDS("row_starts", cata_filter_energies(2, NULL, columns, entries, NULL, c, 1, b, 2, x));
    NEEDS("columns", cata_filter_energies(2, starts, NULL, entries, NULL, c, 1, b, 2, x));
    NEEDS("entries", cata_filter_energies(2, starts, columns, NULL, NULL, c, 1, b, 2, x));
    NEEDS("f", cata_filter_energies(2, starts, columns, entries, NULL, c, 1, NULL, 2, x));
    NEEDS("energies", cata_filter_energies(2, starts, columns, entries, NULL, c, 1, b, 2, NULL));
    TOO_LARGE("ldf", cata_filter_energies(2, starts, columns, entries, NULL, c, 1, b, 1, x));
    NEEDS("P: row_starts", cata_eigs_two_level(2, starts, columns, entries, NULL, 1, NULL, columns,
                                               entries, 1, x, x + 1, 2, NULL, NULL));
    CHECK_STATUS(cata_cholesky_analyse(2, starts, columns, NULL, &cholesky), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, starts, columns, entries), CATA_OK);
    NEEDS("params", cata_cholesky_params_init(NULL, sizeof(cata_cholesky_params)));
    NEEDS("row_starts", cata_cholesky_analyse(2, NULL, columns, NULL, &none));
    NEEDS("columns", cata_cholesky_analyse(2, starts, NULL, NULL, &none));
    NEEDS("cholesky", cata_cholesky_analyse(2, starts, columns, NULL, NULL));
    TOO_LARGE("row_starts", cata_cholesky_analyse(most, starts, columns, NULL, &none));
    NEEDS("cholesky", cata_cholesky_factor(NULL, starts, columns, entries));
    NEEDS("row_starts", cata_cholesky_factor(cholesky, NULL, columns, entries));
    NEEDS("columns", cata_cholesky_factor(cholesky, starts, NULL, entries));
    NEEDS("entries", cata_cholesky_factor(cholesky, starts, columns, NULL));
    NEEDS("cholesky", cata_cholesky_solve(NULL, c, 1, x, 2));
    NEEDS("x", cata_cholesky_solve(cholesky, c, 1, NULL, 2));
    TOO_LARGE("ldx", cata_cholesky_solve(cholesky, c, 1, x, 1));
    NEEDS("cholesky", cata_cholesky_solve_rows(NULL, c, 1, b, 2, 1, &row, x, 1));
    NEEDS("b", cata_cholesky_solve_rows(cholesky, c, 1, NULL, 2, 1, &row, x, 1));
    NEEDS("rows", cata_cholesky_solve_rows(cholesky, c, 1, b, 2, 1, NULL, x, 1));
    NEEDS("x", cata_cholesky_solve_rows(cholesky, c, 1, b, 2, 1, &row, NULL, 1));
    TOO_LARGE("ldb", cata_cholesky_solve_rows(cholesky, c, 1, b, 1, 1, &row, x, 1));
    TOO_LARGE("rows", cata_cholesky_solve_rows(cholesky, c, 1, b, 2, most, &row, x, most));
    NEEDS("cholesky", cata_cholesky_size(NULL, NULL, NULL, NULL));
    NEEDS("cholesky", cata_cholesky_held(NULL, places));
    NEEDS("cholesky", cata_cholesky_weakest(NULL, NULL, NULL));
    /* What was refused has left the factor. */
    CHECK_STATUS(cata_cholesky_solve_rows(cholesky, c, 1, b, 2, 1, &row, x, 1), CATA_OK);
    CHECK(fabs(x[0] - 1) < 1e-15 && none == NULL);
    cata_cholesky_free(cholesky);
}

int main(void)
{
    make_square(SIDE, 1, v, f);
    n = 77;
    number = 77;
    for (size_t i = 0; i < sizeof x / sizeof *x; i++) {
        x[i] = 77;
    }
    test_files();
    test_repair();
    test_laplacians();
    test_distances();
    test_regions();
    test_surfaces();
    test_descriptors();
    int untouched = n == 77 && number == 77;
    for (size_t i = 0; i < sizeof x / sizeof *x; i++) {
        untouched = untouched && x[i] == 77;
    }
    for (size_t i = 0; i < sizeof u / sizeof *u; i++) {
        untouched = untouched && u[i] == 0;
    }
    CHECK(untouched && text[0] == 0 && places[0] == 0);
    test_sparse();
    return report("test_nulls");
}
