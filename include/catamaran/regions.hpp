// Regions of meshes, cuts, and curves drawn into meshes.

#ifndef CATAMARAN_REGIONS_HPP
#define CATAMARAN_REGIONS_HPP

#include "curves.hpp"

#include <memory>

namespace catamaran {

/// Which side of curves is inside.
enum class region_side : std::int32_t { small = CATA_SIDE_SMALL, large = CATA_SIDE_LARGE };

/// A mesh, and where it comes from on another one.
struct mesh_part {
    /// Vertices of the part.
    point_list vertices;
    /// Faces of the part.
    triangle_list faces;
    /// Number of each vertex in the other mesh.
    std::vector<std::uint32_t> of_vertices;
    /// Number of each face in the other mesh.
    std::vector<std::uint32_t> of_faces;

    /// The part, valid as long as this.
    mesh_view mesh() const& { return {vertices, faces}; }
    mesh_view mesh() const&& = delete;
};

namespace detail {

/// The part of a handle, which is freed.
inline mesh_part part_of(cata_part* made) {
    const std::unique_ptr<cata_part, void (*)(cata_part*)> handle(made, cata_part_free);
    std::size_t n_vertices = 0, n_faces = 0;
    check(cata_part_size(made, &n_vertices, &n_faces));
    mesh_part found;
    found.vertices.resize(n_vertices);
    found.faces.resize(n_faces);
    found.of_vertices.resize(n_vertices);
    found.of_faces.resize(n_faces);
    check(cata_part_get(made, first_of(found.vertices), first_of(found.faces),
                        found.of_vertices.data(), found.of_faces.data()));
    return found;
}

}  // namespace detail

/// A set of faces of a mesh.
class region {
public:
    /// 1 for each face inside, 0 for each other.
    explicit region(std::vector<std::uint8_t> inside) : inside_(std::move(inside)) {}

    /// What curves along edges enclose: cata_region_enclosed.
    region(const mesh_view& mesh, const edge_list& along, region_side side = region_side::small)
        : region(enclosed(mesh, along, static_cast<std::int32_t>(side), {})) {}

    /// The pieces between curves that have these vertices.
    region(const mesh_view& mesh, const edge_list& along, const std::vector<std::uint32_t>& seeds)
        : region(enclosed(mesh, along, CATA_SIDE_SEEDS, seeds)) {}

    /// 1 for each face inside, 0 for each other.
    const std::vector<std::uint8_t>& inside() const noexcept { return inside_; }

    /// The faces in one of two regions, or both.
    region operator|(const region& other) const { return with(other, CATA_REGION_UNION); }
    /// The faces in both.
    region operator&(const region& other) const { return with(other, CATA_REGION_INTERSECTION); }
    /// The faces that are not in the other one.
    region operator-(const region& other) const { return with(other, CATA_REGION_DIFFERENCE); }
    /// The faces in one of them alone.
    region operator^(const region& other) const {
        return with(other, CATA_REGION_SYMMETRIC_DIFFERENCE);
    }
    /// The faces that are not in it.
    region operator~() const {
        return region(std::vector<std::uint8_t>(inside_.size(), 1)) - *this;
    }

    /// Returns the area of the faces inside, in squared units of the mesh.
    double area(const mesh_view& mesh) const {
        double area = 0.0;
        detail::check(cata_region_area(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                       of(mesh), &area));
        return area;
    }

    /// The edges between faces inside and others, ascending.
    edge_list boundary(const mesh_view& mesh) const {
        const std::uint8_t* inside = of(mesh);
        std::size_t count = 0;
        detail::check(cata_region_boundary(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                           inside, 0, nullptr, &count));
        edge_list edges(count);
        detail::check(cata_region_boundary(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                           inside, count, detail::first_of(edges), &count));
        return edges;
    }

    /// The faces inside as a mesh.
    mesh_part part(const mesh_view& mesh) const {
        cata_part* made = nullptr;
        detail::check(cata_region_part(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                       of(mesh), &made));
        return detail::part_of(made);
    }

private:
    static std::vector<std::uint8_t> enclosed(const mesh_view& mesh, const edge_list& along,
                                              std::int32_t side,
                                              const std::vector<std::uint32_t>& seeds) {
        std::vector<std::uint8_t> inside(mesh.n_faces);
        detail::check(cata_region_enclosed(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                           along.size(), detail::first_of(along), side,
                                           seeds.size(), seeds.data(), inside.data()));
        return inside;
    }

    region with(const region& other, std::int32_t operation) const {
        detail::require(other.inside_.size() == inside_.size(), CATA_ERR_SHAPE,
                        "region: of a mesh with another number of faces");
        std::vector<std::uint8_t> result(inside_.size());
        detail::check(cata_region_combine(operation, inside_.size(), inside_.data(),
                                          other.inside_.data(), result.data()));
        return region(std::move(result));
    }

    const std::uint8_t* of(const mesh_view& mesh) const {
        detail::require(mesh.n_faces == inside_.size(), CATA_ERR_SHAPE,
                        "region: of a mesh with another number of faces");
        return inside_.data();
    }

    std::vector<std::uint8_t> inside_;
};

/// A mesh that is cut open along edges: cata_region_cut.
inline mesh_part cut(const mesh_view& mesh, const edge_list& along) {
    cata_part* made = nullptr;
    detail::check(cata_region_cut(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                  along.size(), detail::first_of(along), &made));
    return detail::part_of(made);
}

/// A mesh with the curves of a drawing along its edges: cata_drawn.
class drawn_mesh {
public:
    /// Takes a handle of a drawing of a mesh with so many faces, which is freed with this.
    drawn_mesh(cata_drawn* handle, std::size_t n_faces) : handle_(handle), n_faces_(n_faces) {
        std::size_t vertices = 0, faces = 0, layers = 0;
        detail::check(cata_drawn_size(handle, &vertices, &faces, &layers));
        vertices_.resize(vertices);
        faces_.resize(faces);
        of_faces_.resize(faces);
        corners_.resize(vertices);
        weights_.resize(vertices);
        detail::check(cata_drawn_get(handle, detail::first_of(vertices_), detail::first_of(faces_),
                                     of_faces_.data(), detail::first_of(corners_),
                                     detail::first_of(weights_)));
        for (std::size_t layer = 0; layer < layers; ++layer) {
            std::size_t count = 0;
            detail::check(cata_drawn_edges(handle, layer, 0, nullptr, &count));
            edge_list along(count);
            detail::check(cata_drawn_edges(handle, layer, count, detail::first_of(along), &count));
            layers_.push_back(std::move(along));
        }
    }

    /// Vertices of the mesh.
    const point_list& vertices() const noexcept { return vertices_; }
    /// Faces of the mesh.
    const triangle_list& faces() const noexcept { return faces_; }
    /// The mesh, valid as long as this.
    mesh_view mesh() const& { return {vertices_, faces_}; }
    mesh_view mesh() const&& = delete;

    /// For each face the one of the drawing's mesh that contains it.
    const std::vector<std::uint32_t>& of_faces() const noexcept { return of_faces_; }
    /// For each vertex three vertices of the drawing's mesh whose weighted mean it is.
    const triangle_list& corners() const noexcept { return corners_; }
    /// The weights of corners().
    const point_list& weights() const noexcept { return weights_; }
    /// The edges of the curves of each layer.
    const std::vector<edge_list>& layers() const noexcept { return layers_; }

    /// The share of each face of the drawing's mesh that a region of this one covers.
    std::vector<double> shares(const region& of) const {
        detail::require(of.inside().size() == faces_.size(), CATA_ERR_SHAPE,
                        "region: of a mesh with another number of faces");
        std::vector<double> found(n_faces_);
        detail::check(cata_drawn_shares(handle_.get(), of.inside().data(), found.data()));
        return found;
    }

private:
    struct free {
        void operator()(cata_drawn* handle) const noexcept { cata_drawn_free(handle); }
    };

    std::unique_ptr<cata_drawn, free> handle_;
    std::size_t n_faces_;
    point_list vertices_;
    triangle_list faces_;
    std::vector<std::uint32_t> of_faces_;
    triangle_list corners_;
    point_list weights_;
    std::vector<edge_list> layers_;
};

/// Layers of curves on one mesh: cata_drawing. One owner, one thread at a time.
class drawing {
public:
    /// Creates a drawing without curves; a copy of the mesh is kept.
    explicit drawing(const mesh_view& mesh) : n_faces_(mesh.n_faces) {
        cata_drawing* made = nullptr;
        detail::check(cata_drawing_new(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                       &made));
        handle_.reset(made);
    }

    /// Adds the curves that samples (vertices) without an order are of; how the search ended.
    curve_outcome add(const std::vector<std::uint32_t>& samples, const curve_options& how = {}) {
        detail::curve_call call(how);
        std::int32_t outcome = 0;
        call.finish(cata_drawing_add(handle_.get(), samples.size(), samples.data(), &outcome,
                                     call.params()));
        return static_cast<curve_outcome>(outcome);
    }

    /// A mesh with all curves along its edges, which are shortened to geodesics first where
    /// `smooth`; then no curves can be added any more.
    drawn_mesh inscribe(bool smooth = false) {
        cata_drawn* made = nullptr;
        detail::check(cata_drawing_inscribe(handle_.get(), smooth ? 1 : 0, &made));
        return drawn_mesh(made, n_faces_);
    }

private:
    struct free {
        void operator()(cata_drawing* handle) const noexcept { cata_drawing_free(handle); }
    };

    std::size_t n_faces_;
    std::unique_ptr<cata_drawing, free> handle_;
};

}  // namespace catamaran

#endif
