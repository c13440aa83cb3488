// Descriptors of vertices, gains of filters, and shapes from spectra.

#ifndef CATAMARAN_DESCRIPTORS_HPP
#define CATAMARAN_DESCRIPTORS_HPP

#include "eigs.hpp"

#include <utility>

namespace catamaran {

/// How descriptors are computed: the fields of cata_descriptor_params.
struct descriptor_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// Numbers for each vertex.
struct descriptors {
    /// Number of vertices.
    std::size_t rows = 0;
    /// Numbers of each.
    std::size_t cols = 0;
    /// rows x cols, column-major without gaps.
    std::vector<double> entries;

    /// The matrix, valid as long as this.
    matrix_view<const double> matrix() const& noexcept {
        return col_major(entries.data(), rows, cols);
    }
    matrix_view<const double> matrix() const&& = delete;
};

namespace detail {

/// cata_descriptor_params for the length of a call.
class descriptor_call {
public:
    explicit descriptor_call(const descriptor_options& how) : watcher_(how.progress) {
        check(cata_descriptor_params_init(&params_, sizeof params_));
        params_.threads = how.threads;
        watcher_.attach(params_);
    }

    const cata_descriptor_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_descriptor_params params_{};
    watcher watcher_;
};

inline descriptors descriptors_of(std::size_t rows, std::size_t cols) {
    return {rows, cols, std::vector<double>(rows * cols)};
}

inline std::size_t rows_of(const eigenpairs& pairs) {
    require(pairs.vectors.size() == pairs.rows * pairs.values.size(), CATA_ERR_SHAPE,
            "pairs: must have an eigenvector for each value");
    return pairs.rows;
}

/// The leading dimension of columns without gaps.
inline std::size_t column(std::size_t rows) noexcept { return rows ? rows : 1; }

}  // namespace detail

/// Times for heat_kernel_signature: cata_descriptor_heat_times.
inline std::vector<double> heat_times(const eigenpairs& pairs, std::size_t count) {
    std::vector<double> times(count);
    detail::check(cata_descriptor_heat_times(pairs.values.size(), pairs.values.data(), count,
                                             times.data()));
    return times;
}

/// Heat kernel signatures, a column for each time; `scaled`: divided by the heat trace.
inline descriptors heat_kernel_signature(const eigenpairs& pairs, const std::vector<double>& times,
                                         bool scaled = false, const descriptor_options& how = {}) {
    const std::size_t n = detail::rows_of(pairs);
    descriptors found = detail::descriptors_of(n, times.size());
    detail::descriptor_call call(how);
    call.finish(cata_descriptor_heat(CATA_COL_MAJOR, n, pairs.values.size(), pairs.values.data(),
                                     pairs.vectors.data(), detail::column(n), times.size(),
                                     times.data(), scaled ? 1 : 0, found.entries.data(),
                                     detail::column(n), call.params()));
    return found;
}

/// The heat of a vertex, per area, at every vertex after a time: cata_descriptor_heat_kernel.
inline std::vector<double> heat_kernel(const eigenpairs& pairs, std::uint32_t source, double time) {
    const std::size_t n = detail::rows_of(pairs);
    std::vector<double> heat(n);
    detail::check(cata_descriptor_heat_kernel(CATA_COL_MAJOR, n, pairs.values.size(),
                                              pairs.values.data(), pairs.vectors.data(),
                                              detail::column(n), source, time, heat.data()));
    return heat;
}

/// Energies of wave kernel signatures, and their width.
struct wave_scales {
    /// Logarithms of eigenvalues, ascending.
    std::vector<double> energies;
    /// Width of the weights around an energy, in logarithms of eigenvalues.
    double sigma = 0.0;
};

/// Energies at equal distances: cata_descriptor_wave_scales.
inline wave_scales wave_scales_of(const eigenpairs& pairs, std::size_t count) {
    wave_scales scales;
    scales.energies.resize(count);
    detail::check(cata_descriptor_wave_scales(pairs.values.size(), pairs.values.data(), count,
                                              scales.energies.data(), &scales.sigma));
    return scales;
}

/// Wave kernel signatures, a column for each energy.
inline descriptors wave_kernel_signature(const eigenpairs& pairs, const wave_scales& scales,
                                         const descriptor_options& how = {}) {
    const std::size_t n = detail::rows_of(pairs), count = scales.energies.size();
    descriptors found = detail::descriptors_of(n, count);
    detail::descriptor_call call(how);
    call.finish(cata_descriptor_wave(CATA_COL_MAJOR, n, pairs.values.size(), pairs.values.data(),
                                     pairs.vectors.data(), detail::column(n), count,
                                     scales.energies.data(), scales.sigma, found.entries.data(),
                                     detail::column(n), call.params()));
    return found;
}

/// Global point signatures, a column for each eigenvalue that is not 0: cata_descriptor_points.
inline descriptors global_point_signature(const eigenpairs& pairs) {
    const std::size_t n = detail::rows_of(pairs), k = pairs.values.size();
    descriptors found = detail::descriptors_of(n, k);
    std::size_t count = 0;
    detail::check(cata_descriptor_points(CATA_COL_MAJOR, n, k, pairs.values.data(),
                                         pairs.vectors.data(), detail::column(n), &count,
                                         found.entries.data(), detail::column(n)));
    found.cols = count;
    found.entries.resize(n * count);
    return found;
}

/// Signatures of histograms of orientations: cata_descriptor_shot.
inline descriptors shot(const mesh_view& mesh, double radius, const descriptor_options& how = {}) {
    descriptors found = detail::descriptors_of(mesh.n_vertices, CATA_SHOT_BINS);
    detail::descriptor_call call(how);
    call.finish(cata_descriptor_shot(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                     radius, CATA_COL_MAJOR, found.entries.data(),
                                     detail::column(mesh.n_vertices), call.params()));
    return found;
}

/// Means of functions, a row for each vertex, over rings around vertices: cata_descriptor_rings.
inline descriptors geodesic_rings(const mesh_view& mesh, matrix_view<const double> f, double radius,
                                  std::size_t rings, const descriptor_options& how = {}) {
    detail::require(f.rows == mesh.n_vertices, CATA_ERR_SHAPE,
                    "f: must have a row for each vertex");
    detail::require(f.order == layout::col_major, CATA_ERR_ARGUMENT, "f: must be column-major");
    descriptors found = detail::descriptors_of(mesh.n_vertices, rings * (1 + f.cols));
    detail::descriptor_call call(how);
    call.finish(cata_descriptor_rings(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                      radius, rings, CATA_COL_MAJOR, f.cols, f.data, f.leading,
                                      found.entries.data(), detail::column(mesh.n_vertices),
                                      call.params()));
    return found;
}

/// Which frequencies a filter lets pass.
enum class response : std::int32_t {
    low_pass = CATA_RESPONSE_LOW_PASS,
    high_pass = CATA_RESPONSE_HIGH_PASS,
    band_pass = CATA_RESPONSE_BAND_PASS,
    heat = CATA_RESPONSE_HEAT,
    sharpen = CATA_RESPONSE_SHARPEN,
};

/// What basis::filter takes.
struct filter_gains {
    /// One for each frequency.
    std::vector<double> gains;
    /// Beyond all of them.
    double rest = 0.0;
};

/// The gains of a filter for eigenvalues, or energies: cata_filter_gains.
inline filter_gains gains_of(response kind, const std::vector<double>& frequencies, double first,
                             double second = 0.0) {
    filter_gains found{std::vector<double>(frequencies.size()), 0.0};
    detail::check(cata_filter_gains(static_cast<std::int32_t>(kind), first, second,
                                    frequencies.size(), frequencies.data(), found.gains.data(),
                                    &found.rest));
    return found;
}

/// The frequencies of functions, the columns of f: cata_filter_energies. `masses`: the diagonal of
/// M, empty: all 1.
inline std::vector<double> dirichlet_energies(const sparse_view& w, matrix_view<const double> f,
                                              const std::vector<double>& masses = {}) {
    detail::require(f.rows == w.rows, CATA_ERR_SHAPE, "f: must have a row for each row of w");
    std::vector<double> found(f.cols);
    detail::check(cata_filter_energies(w.rows, w.row_starts, w.columns, w.entries,
                                       detail::masses_of(masses, w.rows),
                                       static_cast<std::int32_t>(f.order), f.cols, f.data,
                                       f.leading, found.data()));
    return found;
}

/// How a template is deformed: the fields of cata_shape_params.
struct shape_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Steps, at most; 0: 60.
    std::size_t steps = 0;
    /// Mean relative difference of eigenvalues at which it ends; 0: 0.001.
    double tolerance = 0.0;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// A template that was deformed.
struct shape_from_spectrum_result {
    /// Its vertices, moved.
    point_list vertices;
    /// Its first eigenvalues.
    std::vector<double> eigenvalues;
    /// Mean relative difference of the eigenvalues from those that were given.
    double error = 0.0;
    /// How many steps were taken.
    std::size_t steps = 0;
};

/// Deforms a mesh until it has these first eigenvalues, or nearly: cata_shape_from_spectrum.
inline shape_from_spectrum_result shape_from_spectrum(const mesh_view& mesh,
                                                      const std::vector<double>& eigenvalues,
                                                      const shape_options& how = {}) {
    cata_shape_params params;
    detail::check(cata_shape_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.steps = how.steps;
    params.tolerance = how.tolerance;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    shape_from_spectrum_result found;
    found.vertices.resize(mesh.n_vertices);
    found.eigenvalues.resize(eigenvalues.size());
    watcher.finish(cata_shape_from_spectrum(
        mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, eigenvalues.size(),
        eigenvalues.data(), detail::first_of(found.vertices), found.eigenvalues.data(),
        &found.error, &found.steps, &params));
    return found;
}

}  // namespace catamaran

#endif
