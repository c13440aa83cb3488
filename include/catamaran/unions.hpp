// Spectral unions.

#ifndef CATAMARAN_UNIONS_HPP
#define CATAMARAN_UNIONS_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

/// How a union is located: the fields of cata_unions_params.
struct unions_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// The network that predicts spectra of unions of parts from those of the parts. One owner; calls
/// may run at the same time.
class unions {
public:
    /// The first Dirichlet eigenvalues of a part, ascending and positive, in whatever unit.
    using eigenvalues = std::array<double, CATA_UNION_EIGENVALUES>;

    /// Creates the network with the weights of the library.
    unions() : handle_(made(nullptr)) {}

    /// Creates the network with weights in a file of `catamaran unions train`.
    explicit unions(const std::string& weights) : handle_(made(weights.c_str())) {}

    /// What predict finds.
    struct prediction {
        /// Eigenvalues of the union: ascending, none above that of a part.
        eigenvalues values;
        /// How unlike the parts are to those of the training; above 1 the prediction is a guess.
        double ood_score;
    };

    /// Predicts the eigenvalues of the union of these parts, at least one.
    prediction predict(const std::vector<eigenvalues>& parts) const {
        prediction found{};
        detail::check(cata_unions_predict(handle_.get(), parts.size(), detail::first_of(parts),
                                          found.values.data(), &found.ood_score));
        return found;
    }

    /// Where the union is on the template, the mesh that `catamaran unions template` writes: for
    /// each vertex about 1 inside and 0 outside.
    std::vector<double> locate(const std::vector<eigenvalues>& parts, const mesh_view& mesh,
                               const unions_options& how = {}) const {
        std::vector<double> indicator(mesh.n_vertices);
        cata_unions_params params;
        detail::check(cata_unions_params_init(&params, sizeof params));
        params.threads = how.threads;
        detail::watcher watcher(how.progress);
        watcher.attach(params);
        watcher.finish(cata_unions_locate(
            handle_.get(), parts.size(), detail::first_of(parts), mesh.n_vertices, mesh.vertices,
            mesh.n_faces, mesh.faces, indicator.data(), &params));
        return indicator;
    }

    /// A spectrum between two: (1 - t) first + t second.
    static eigenvalues interpolate(const eigenvalues& first, const eigenvalues& second, double t) {
        eigenvalues between{};
        detail::check(cata_unions_interpolate(first.data(), second.data(), t, between.data()));
        return between;
    }

    /// The handle, owned by this.
    const cata_unions* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_unions* handle) const noexcept { cata_unions_free(handle); }
    };

    static cata_unions* made(const char* weights) {
        cata_unions* handle = nullptr;
        detail::check(cata_unions_new(weights, &handle));
        return handle;
    }

    std::unique_ptr<cata_unions, free> handle_;
};

}  // namespace catamaran

#endif
