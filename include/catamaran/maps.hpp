// Bases of eigenfunctions and their products, functional maps, functions and details carried from
// one shape to another, ShapeDNA.

#ifndef CATAMARAN_MAPS_HPP
#define CATAMARAN_MAPS_HPP

#include "eigs.hpp"

#include <memory>

namespace catamaran {

/// How bases of products are made and other work is done: the fields of cata_basis_params.
struct basis_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Most factors of a product; 0: 2.
    std::size_t order = 0;
    /// Method that makes products orthonormal; standard: single_pass, which is more stable under
    /// transfer.
    ortho_method method = ortho_method::standard;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

namespace detail {

/// cata_basis_params for the length of a call.
class basis_call {
public:
    explicit basis_call(const basis_options& options) : watcher_(options.progress) {
        check(cata_basis_params_init(&params_, sizeof params_));
        params_.threads = options.threads;
        params_.order = options.order;
        params_.method = static_cast<std::int32_t>(options.method);
        watcher_.attach(params_);
    }

    const cata_basis_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_basis_params params_{};
    watcher watcher_;
};

}  // namespace detail

/// Functions on the vertices of a mesh, with the inner product of its masses. Functions that are
/// taken have a row for each vertex and are columns; those that are returned are in the same
/// layout, without gaps.
class basis {
public:
    /// Creates a basis of eigenpairs of a mesh, with their masses.
    explicit basis(const eigenpairs& pairs, const basis_options& how = {}) {
        detail::require(pairs.masses.size() == pairs.rows, CATA_ERR_ARGUMENT,
                        "pairs: must have masses");
        detail::require(pairs.vectors.size() >= pairs.rows * pairs.values.size(), CATA_ERR_SHAPE,
                        "pairs: must have an eigenvector for each value");
        detail::basis_call call(how);
        cata_basis* made = nullptr;
        call.finish(cata_basis_new(pairs.rows, pairs.values.size(), pairs.masses.data(),
                                   pairs.values.data(), pairs.vectors.data(),
                                   pairs.rows ? pairs.rows : 1, call.params(), &made));
        handle_.reset(made);
    }

    /// Returns a basis of products of these eigenfunctions: cata_basis_products.
    basis products(const basis_options& how = {}) const {
        detail::basis_call call(how);
        cata_basis* made = nullptr;
        call.finish(cata_basis_products(handle_.get(), call.params(), &made));
        return basis(made);
    }

    /// Number of rows of each function.
    std::size_t vertices() const { return sizes()[0]; }

    /// Number of functions.
    std::size_t size() const { return sizes()[1]; }

    /// The functions Q, column-major without gaps.
    std::vector<double> functions() const {
        const auto [n, r, all] = sizes();
        (void)all;
        std::vector<double> q(n * r);
        detail::check(cata_basis_copy(handle_.get(), CATA_COL_MAJOR, q.data(), n ? n : 1, nullptr,
                                      0, nullptr));
        return q;
    }

    /// Returns, for a basis of products, R, column-major without gaps, and the products from which
    /// functions come.
    catamaran::factors factors() const {
        const auto [n, r, all] = sizes();
        (void)n;
        catamaran::factors found{std::vector<double>(r * all), std::vector<std::size_t>(r)};
        detail::check(cata_basis_copy(handle_.get(), CATA_COL_MAJOR, nullptr, 0, found.r.data(),
                                      r ? r : 1, found.kept.data()));
        return found;
    }

    /// Returns the coefficients of f, size() x columns of f.
    std::vector<double> analysis(matrix_view<const double> f) const {
        const std::size_t r = take(f);
        std::vector<double> c(r * f.cols);
        detail::check(cata_basis_analysis(handle_.get(), order(f), f.cols, f.data, f.leading,
                                          c.data(), detail::gapless(f.order, r, f.cols)));
        return c;
    }

    /// The functions with these coefficients, size() rows.
    std::vector<double> synthesis(matrix_view<const double> c) const {
        const auto [n, r, all] = sizes();
        (void)all;
        detail::require(c.rows == r, CATA_ERR_SHAPE, "c: must have a row for each function");
        std::vector<double> f(n * c.cols);
        detail::check(cata_basis_synthesis(handle_.get(), order(c), c.cols, c.data, c.leading,
                                           f.data(), detail::gapless(c.order, n, c.cols)));
        return f;
    }

    /// Coefficients multiplied by gains, one for each function, and what is outside by `rest`.
    std::vector<double> filter(matrix_view<const double> f, const std::vector<double>& gains,
                               double rest = 0.0) const {
        detail::require(gains.size() == take(f), CATA_ERR_SHAPE,
                        "gains: must be as many as functions");
        std::vector<double> g(f.rows * f.cols);
        detail::check(cata_basis_filter(handle_.get(), order(f), f.cols, f.data, f.leading,
                                        gains.data(), rest, g.data(),
                                        detail::gapless(f.order, f.rows, f.cols)));
        return g;
    }

    /// Adds `amount` times the function `index` to the columns of f.
    void add_coefficient(std::size_t index, double amount, matrix_view<double> f) const {
        take(f);
        detail::check(cata_basis_add_coefficient(handle_.get(), index, amount, order(f), f.cols,
                                                 f.data, f.leading));
    }

    /// Functions in two parts, each in their layout without gaps.
    struct parts {
        /// What of f is in the span.
        std::vector<double> low;
        /// The detail that is left.
        std::vector<double> high;
    };

    /// f as low + high.
    parts split(matrix_view<const double> f) const {
        take(f);
        parts found{std::vector<double>(f.rows * f.cols), std::vector<double>(f.rows * f.cols)};
        const std::size_t leading = detail::gapless(f.order, f.rows, f.cols);
        detail::check(cata_basis_split(handle_.get(), order(f), f.cols, f.data, f.leading,
                                       found.low.data(), leading, found.high.data(), leading));
        return found;
    }

    /// The handle, owned by this.
    const cata_basis* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_basis* handle) const noexcept { cata_basis_free(handle); }
    };

    explicit basis(cata_basis* handle) : handle_(handle) {}

    std::array<std::size_t, 3> sizes() const {
        std::array<std::size_t, 3> found{};
        detail::check(cata_basis_size(handle_.get(), &found[0], &found[1], &found[2]));
        return found;
    }

    /// Refuses what are no functions of these vertices; the number of functions of the basis.
    std::size_t take(matrix_view<const double> f) const {
        const auto [n, r, all] = sizes();
        (void)all;
        detail::require(f.rows == n, CATA_ERR_SHAPE, "functions: must have a row for each vertex");
        return r;
    }

    static std::int32_t order(matrix_view<const double> f) {
        return static_cast<std::int32_t>(f.order);
    }

    std::unique_ptr<cata_basis, free> handle_;
};

/// A functional map, target.size() x source.size(), column-major without gaps, and, where they were
/// computed, its points: the vertex of the source for each of the target.
struct functional_map {
    /// Functions of the target.
    std::size_t rows = 0;
    /// Functions of the source.
    std::size_t cols = 0;
    /// rows x cols, column-major without gaps.
    std::vector<double> entries;
    /// For each vertex of the target that of the source; none where they were not computed.
    std::vector<std::uint32_t> points;

    /// The entries, valid as long as this.
    matrix_view<const double> matrix() const& noexcept {
        return col_major(entries.data(), rows, cols);
    }
    matrix_view<const double> matrix() const&& = delete;
};

namespace detail {

/// Takes the entries of a map from those in a layout without gaps.
inline void by_columns(const std::vector<double>& whole, layout order, functional_map& found) {
    const matrix_view<const double> view{whole.data(), found.rows, found.cols,
                                         gapless(order, found.rows, found.cols), order};
    for (std::size_t j = 0; j < found.cols; ++j) {
        for (std::size_t i = 0; i < found.rows; ++i) {
            found.entries[i + j * found.rows] = view(i, j);
        }
    }
}

}  // namespace detail

/// A functional map between two bases of eigenfunctions that is being fitted. It goes on without
/// them.
class map_fit {
public:
    /// Creates a fit without data, with the threads of `source`.
    map_fit(const basis& source, const basis& target)
        : rows_(target.size()),
          cols_(source.size()),
          source_(source.vertices()),
          target_(target.vertices()) {
        cata_map_fit* made = nullptr;
        detail::check(cata_map_fit_new(source.get(), target.get(), &made));
        handle_.reset(made);
    }

    /// Adds functions that correspond, columns of f on the source and of g on the target.
    map_fit& functions(matrix_view<const double> f, matrix_view<const double> g) {
        pair(f, g);
        detail::check(cata_map_fit_functions(handle_.get(), static_cast<std::int32_t>(f.order),
                                             f.cols, f.data, f.leading, g.data, g.leading));
        return *this;
    }

    /// Adds the condition that the map commutes with multiplications by these functions.
    map_fit& operators(matrix_view<const double> f, matrix_view<const double> g,
                       double weight = 0.1) {
        pair(f, g);
        detail::check(cata_map_fit_operators(handle_.get(), static_cast<std::int32_t>(f.order),
                                             f.cols, f.data, f.leading, g.data, g.leading,
                                             weight));
        return *this;
    }

    /// Adds vertices (source, target) that correspond.
    map_fit& landmarks(const std::vector<std::array<std::uint32_t, 2>>& pairs) {
        detail::check(
            cata_map_fit_landmarks(handle_.get(), pairs.size(), detail::first_of(pairs)));
        return *this;
    }

    /// Adds segments that correspond: a label for each vertex.
    map_fit& segments(const std::vector<std::uint32_t>& source,
                      const std::vector<std::uint32_t>& target) {
        detail::require(source.size() == source_ && target.size() == target_, CATA_ERR_SHAPE,
                        "labels: must be as many as vertices");
        detail::check(cata_map_fit_segments(handle_.get(), source.data(), target.data()));
        return *this;
    }

    /// Adds heat and wave kernel signatures of bases of the same meshes, with more functions or as
    /// many.
    map_fit& signatures(const basis& source, const basis& target) {
        detail::check(cata_map_fit_signatures(handle_.get(), source.get(), target.get()));
        return *this;
    }

    /// The map that fits best and, by a weight from 0 on, commutes with the Laplacians; no points.
    functional_map solve(double commutativity = 1e-3, const basis_options& how = {}) {
        functional_map found{rows_, cols_, std::vector<double>(rows_ * cols_), {}};
        detail::basis_call call(how);
        call.finish(cata_map_fit_solve(handle_.get(), commutativity, CATA_COL_MAJOR,
                                       found.entries.data(), rows_ ? rows_ : 1, call.params()));
        return found;
    }

private:
    struct free {
        void operator()(cata_map_fit* handle) const noexcept { cata_map_fit_free(handle); }
    };

    void pair(matrix_view<const double> f, matrix_view<const double> g) const {
        detail::require(f.rows == source_ && g.rows == target_ && f.cols == g.cols, CATA_ERR_SHAPE,
                        "functions: must have a row for each vertex, and be as many on both");
        detail::require(f.order == g.order, CATA_ERR_ARGUMENT, "functions: must have one layout");
    }

    std::size_t rows_, cols_, source_, target_;
    std::unique_ptr<cata_map_fit, free> handle_;
};

namespace detail {

/// Refuses what is no map between these bases.
inline void require_map(matrix_view<const double> c, const basis& source, const basis& target) {
    require(c.rows == target.size() && c.cols == source.size(), CATA_ERR_SHAPE,
            "map: must have a row for each function of the target, a column for one of the source");
}

}  // namespace detail

/// Iterative closest points: cata_map_icp.
inline functional_map icp(functional_map map, const basis& source, const basis& target,
                          std::size_t iterations, const basis_options& how = {}) {
    detail::require_map(map.matrix(), source, target);
    detail::require(map.entries.size() == map.rows * map.cols, CATA_ERR_SHAPE,
                    "map: must have rows x cols entries");
    map.points.resize(target.vertices());
    detail::basis_call call(how);
    call.finish(cata_map_icp(source.get(), target.get(), iterations, CATA_COL_MAJOR,
                             map.entries.data(), map.rows ? map.rows : 1, map.points.data(),
                             call.params()));
    return map;
}

/// ZoomOut, from a map between the first functions: cata_map_zoomout.
inline functional_map zoomout(matrix_view<const double> map, const basis& source,
                              const basis& target, std::size_t step = 1,
                              const basis_options& how = {}) {
    functional_map found{target.size(), source.size(), {}, {}};
    found.entries.resize(found.rows * found.cols);
    found.points.resize(target.vertices());
    // The layout of the map holds for the result too.
    std::vector<double> whole(found.entries.size());
    detail::basis_call call(how);
    call.finish(cata_map_zoomout(source.get(), target.get(), step,
                                 static_cast<std::int32_t>(map.order), map.rows, map.cols, map.data,
                                 map.leading, whole.data(),
                                 detail::gapless(map.order, found.rows, found.cols),
                                 found.points.data(), call.params()));
    detail::by_columns(whole, map.order, found);
    return found;
}

/// A map that was found without known correspondences, and its quality.
struct found_map {
    /// The map between all functions, and its points.
    functional_map map;
    /// Whether another map may be the true one, so that this one is to be checked.
    bool is_ambiguous = false;
    /// |C L - L' C|^2 / |L|^2 for meshes of area 1.
    double commutativity = 0.0;
    /// That of the next best map that keeps the orientation; infinite without one.
    double next = 0.0;
    /// From -1 to 1; near 1 for a map that keeps the orientation.
    double orientation = 0.0;
};

/// The map of two nearly isometric meshes that keeps left and right: cata_map_search.
inline found_map search_map(const basis& source, const basis& target, const mesh_view& source_mesh,
                            const mesh_view& target_mesh, const basis_options& how = {}) {
    detail::require(source_mesh.n_vertices == source.vertices() &&
                        target_mesh.n_vertices == target.vertices(),
                    CATA_ERR_SHAPE, "meshes: must have the vertices of the bases");
    found_map found;
    found.map.rows = target.size();
    found.map.cols = source.size();
    found.map.entries.resize(found.map.rows * found.map.cols);
    found.map.points.resize(target.vertices());
    std::int32_t is_ambiguous = 0;
    detail::basis_call call(how);
    call.finish(cata_map_search(source.get(), target.get(), source_mesh.vertices,
                                source_mesh.n_faces, source_mesh.faces, target_mesh.vertices,
                                target_mesh.n_faces, target_mesh.faces, CATA_COL_MAJOR,
                                found.map.entries.data(), found.map.rows ? found.map.rows : 1,
                                found.map.points.data(), &is_ambiguous, &found.commutativity,
                                &found.next, &found.orientation, call.params()));
    found.is_ambiguous = is_ambiguous != 0;
    return found;
}

/// The points of a map between any bases: cata_map_points.
inline std::vector<std::uint32_t> points_from_map(matrix_view<const double> map,
                                                  const basis& source, const basis& target,
                                                  const basis_options& how = {}) {
    detail::require_map(map, source, target);
    std::vector<std::uint32_t> points(target.vertices());
    detail::basis_call call(how);
    call.finish(cata_map_points(source.get(), target.get(), static_cast<std::int32_t>(map.order),
                                map.data, map.leading, points.data(), call.params()));
    return points;
}

/// The map along points between any bases: cata_map_from_points.
inline functional_map map_from_points(std::vector<std::uint32_t> points, const basis& source,
                                      const basis& target, const basis_options& how = {}) {
    detail::require(points.size() == target.vertices(), CATA_ERR_SHAPE,
                    "points: must be as many as vertices of the target");
    functional_map found{target.size(), source.size(), {}, std::move(points)};
    found.entries.resize(found.rows * found.cols);
    detail::basis_call call(how);
    call.finish(cata_map_from_points(source.get(), target.get(), found.points.data(),
                                     CATA_COL_MAJOR, found.entries.data(),
                                     found.rows ? found.rows : 1, call.params()));
    return found;
}

/// The map of products of eigenfunctions that a map of the eigenfunctions implies, column by
/// column, or by least squares `of_all` products: cata_product_map. It has no points.
inline functional_map product_map(matrix_view<const double> map, const basis& source_eigen,
                                  const basis& target_eigen, const basis& source,
                                  const basis& target, bool of_all = false,
                                  const basis_options& how = {}) {
    detail::require_map(map, source_eigen, target_eigen);
    functional_map found{target.size(), source.size(), {}, {}};
    found.entries.resize(found.rows * found.cols);
    // The layout of the map holds for the result too.
    std::vector<double> whole(found.entries.size());
    detail::basis_call call(how);
    call.finish(cata_product_map(source_eigen.get(), target_eigen.get(), source.get(),
                                 target.get(), static_cast<std::int32_t>(map.order), map.data,
                                 map.leading, of_all ? 1 : 0, whole.data(),
                                 detail::gapless(map.order, found.rows, found.cols),
                                 call.params()));
    detail::by_columns(whole, map.order, found);
    return found;
}

/// Functions on the source mesh, one a column, as functions on the target mesh, in the same layout
/// without gaps, along points and through products: cata_transfer.
inline std::vector<double> transfer(const basis& source, const basis& target,
                                    const std::vector<std::uint32_t>& points,
                                    matrix_view<const double> functions,
                                    const basis_options& how = {}) {
    const std::size_t rows = target.vertices();
    detail::require(points.size() == rows, CATA_ERR_SHAPE,
                    "points: must be as many as vertices of the target");
    detail::require(functions.rows == source.vertices(), CATA_ERR_SHAPE,
                    "functions: must have a row for each vertex of the source");
    std::vector<double> found(rows * functions.cols);
    detail::basis_call call(how);
    call.finish(cata_transfer(source.get(), target.get(), points.data(),
                              static_cast<std::int32_t>(functions.order), functions.cols,
                              functions.data, functions.leading, found.data(),
                              detail::gapless(functions.order, rows, functions.cols),
                              call.params()));
    return found;
}

/// The same, of eigenpairs of meshes, the constant among them.
inline std::vector<double> transfer(const eigenpairs& source, const eigenpairs& target,
                                    const std::vector<std::uint32_t>& points,
                                    matrix_view<const double> functions,
                                    const basis_options& how = {}) {
    return transfer(basis(source), basis(target), points, functions, how);
}

/// Functions carried over by a map between any bases: cata_transfer_map. All in the layout of the
/// functions.
inline std::vector<double> transfer(const basis& source, const basis& target,
                                    matrix_view<const double> map,
                                    matrix_view<const double> functions,
                                    const basis_options& how = {}) {
    detail::require_map(map, source, target);
    detail::require(map.order == functions.order, CATA_ERR_ARGUMENT,
                    "map, functions: must have one layout");
    detail::require(functions.rows == source.vertices(), CATA_ERR_SHAPE,
                    "functions: must have a row for each vertex of the source");
    const std::size_t rows = target.vertices();
    std::vector<double> found(rows * functions.cols);
    detail::basis_call call(how);
    call.finish(cata_transfer_map(source.get(), target.get(), static_cast<std::int32_t>(map.order),
                                  map.data, map.leading, functions.cols, functions.data,
                                  functions.leading, found.data(),
                                  detail::gapless(functions.order, rows, functions.cols),
                                  call.params()));
    return found;
}

/// A shape whose details are carried, or that gets them.
struct detailed_shape {
    /// Mesh at whose vertices the functions have values.
    mesh_view mesh;
    /// A basis of few functions, whose span has the smooth part.
    const basis& smooth;
    /// Basis of the map.
    const basis& functions;
};

/// The vertices of the target with the details of the source: cata_transfer_details.
inline point_list transfer_details(const detailed_shape& source, const detailed_shape& target,
                                   matrix_view<const double> map, const basis_options& how = {}) {
    detail::require_map(map, source.functions, target.functions);
    point_list moved(target.mesh.n_vertices);
    detail::basis_call call(how);
    call.finish(cata_transfer_details(
        source.mesh.n_vertices, source.mesh.vertices, source.mesh.n_faces, source.mesh.faces,
        target.mesh.n_vertices, target.mesh.vertices, target.mesh.n_faces, target.mesh.faces,
        source.smooth.get(), target.smooth.get(), source.functions.get(), target.functions.get(),
        static_cast<std::int32_t>(map.order), map.data, map.leading, detail::first_of(moved),
        call.params()));
    return moved;
}

/// ShapeDNA: the k smallest eigenvalues of a mesh, times its area where they are normalized.
inline std::vector<double> shape_dna(const mesh_view& mesh, std::size_t k, bool normalized = true,
                                     const eigs_options& how = {}) {
    detail::require(k <= mesh.n_vertices, CATA_ERR_ARGUMENT, "k: more eigenvalues than vertices");
    std::vector<double> signature(k);
    detail::eigs_call call(how);
    call.finish(cata_shape_dna(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, k,
                               normalized ? 1 : 0, signature.data(), call.params()));
    return signature;
}

/// The signatures nearest to a query.
struct matches {
    /// Indices of the signatures, from 0, the nearest first.
    std::vector<std::size_t> indices;
    /// Euclidean distances, as many as indices.
    std::vector<double> distances;
};

/// At most `wanted` of the signatures, the rows of a row-major matrix: cata_shape_dna_retrieve.
inline matches retrieve(const std::vector<double>& query, matrix_view<const double> signatures,
                        std::size_t wanted) {
    detail::require(signatures.cols == query.size(), CATA_ERR_SHAPE,
                    "signatures: must be as long as the query");
    detail::require(signatures.order == layout::row_major &&
                        (signatures.rows < 2 || signatures.leading == signatures.cols),
                    CATA_ERR_ARGUMENT, "signatures: must be row-major without gaps");
    wanted = wanted < signatures.rows ? wanted : signatures.rows;
    matches found{std::vector<std::size_t>(wanted), std::vector<double>(wanted)};
    detail::check(cata_shape_dna_retrieve(query.size(), query.data(), signatures.rows,
                                          signatures.data, wanted, found.indices.data(),
                                          found.distances.data()));
    return found;
}

}  // namespace catamaran

#endif
