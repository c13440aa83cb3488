// Mesh files and repair.

#ifndef CATAMARAN_MESHES_HPP
#define CATAMARAN_MESHES_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

/// The format of a mesh file.
enum class mesh_format : std::int32_t {
    by_name = CATA_MESH_BY_NAME,
    obj = CATA_MESH_OBJ,
    ply = CATA_MESH_PLY,
    ply_text = CATA_MESH_PLY_TEXT,
    off = CATA_MESH_OFF,
    stl = CATA_MESH_STL,
    stl_text = CATA_MESH_STL_TEXT,
    glb = CATA_MESH_GLB,
    gltf = CATA_MESH_GLTF,
    vtk = CATA_MESH_VTK,
    vtk_text = CATA_MESH_VTK_TEXT,
    gifti = CATA_MESH_GIFTI,
    threemf = CATA_MESH_3MF,
    vtk_xml = CATA_MESH_VTK_XML,
    freesurfer = CATA_MESH_FREESURFER,
    gmsh = CATA_MESH_GMSH,
};

/// What names of faces are.
enum class mesh_names : std::int32_t {
    materials = CATA_MESH_MATERIALS,
    groups = CATA_MESH_GROUPS,
    objects = CATA_MESH_OBJECTS,
};

/// How mesh files are read and written: the fields of cata_mesh_file_params.
struct mesh_file_options {
    /// Bytes of memory that reading may take; 0: a hundred times the size of the file, or 1 GiB
    /// if that is more.
    std::uint64_t max_memory = 0;
    /// Format of the file that is written.
    mesh_format format = mesh_format::by_name;
    /// Whether writing to an existing file is an error; else the file is replaced.
    bool keep = false;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// Names of faces, and the number of the name of each; CATA_MESH_NO_NAME where it has none.
struct face_names {
    /// The names.
    std::vector<std::string> names;
    /// One for each face.
    std::vector<std::uint32_t> of_faces;
};

/// A function on the vertices of a file.
struct vertex_scalars {
    /// The name, as in the file.
    std::string name;
    /// One for each vertex; NaN where there is none.
    std::vector<double> values;
};

namespace detail {

/// cata_mesh_file_params for the length of a call.
class mesh_file_call {
public:
    explicit mesh_file_call(const mesh_file_options& how) : watcher_(how.progress) {
        check(cata_mesh_file_params_init(&params_, sizeof params_));
        params_.max_memory = how.max_memory;
        params_.format = static_cast<std::int32_t>(how.format);
        params_.keep = how.keep ? 1 : 0;
        watcher_.attach(params_);
    }

    const cata_mesh_file_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_mesh_file_params params_{};
    watcher watcher_;
};

}  // namespace detail

/// A mesh with its attributes, as in a file: cata_mesh_file.
class mesh_file {
public:
    /// Creates a mesh without attributes from a copy.
    explicit mesh_file(const mesh_view& mesh) {
        cata_mesh_file* made = nullptr;
        detail::check(cata_mesh_file_new(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                         &made));
        take(made);
    }

    /// Takes a handle, which is freed with this.
    explicit mesh_file(cata_mesh_file* handle) { take(handle); }

    /// The mesh in a file.
    static mesh_file read(const std::string& path, const mesh_file_options& how = {}) {
        detail::mesh_file_call call(how);
        cata_mesh_file* made = nullptr;
        call.finish(cata_mesh_file_read(path.c_str(), call.params(), &made));
        return mesh_file(made);
    }

    /// The mesh in the bytes of a file.
    static mesh_file read(const std::vector<std::uint8_t>& bytes, mesh_format format) {
        cata_mesh_file* made = nullptr;
        detail::check(cata_mesh_file_read_bytes(bytes.size(), bytes.data(),
                                                static_cast<std::int32_t>(format), &made));
        return mesh_file(made);
    }

    /// Writes a file, which appears whole or not at all; notes() say what it does not hold.
    void write(const std::string& path, const mesh_file_options& how = {}) {
        detail::mesh_file_call call(how);
        call.finish(cata_mesh_file_write(handle_.get(), path.c_str(), call.params()));
    }

    /// The bytes of a file; notes() say what it does not hold.
    std::vector<std::uint8_t> write(mesh_format format) {
        cata_mesh_bytes* made = nullptr;
        detail::check(cata_mesh_file_write_bytes(handle_.get(), static_cast<std::int32_t>(format),
                                                 &made));
        const std::unique_ptr<cata_mesh_bytes, void (*)(cata_mesh_bytes*)> bytes(
            made, cata_mesh_bytes_free);
        std::size_t size = 0;
        detail::check(cata_mesh_bytes_size(made, &size));
        std::vector<std::uint8_t> found(size);
        detail::check(cata_mesh_bytes_get(made, found.data()));
        return found;
    }

    /// The vertices.
    const point_list& vertices() const noexcept { return vertices_; }
    /// The faces.
    const triangle_list& faces() const noexcept { return faces_; }

    /// The mesh, valid as long as this.
    mesh_view mesh() const& { return {vertices_, faces_}; }
    mesh_view mesh() const&& = delete;

    /// Whether there are texture coordinates.
    bool has_uv() const { return has()[0] != 0; }
    /// Whether there are normals.
    bool has_normals() const { return has()[1] != 0; }
    /// Whether there are colours.
    bool has_colors() const { return has()[2] != 0; }

    /// Texture coordinates: u and v at the corners of each face, NaN where it has none.
    std::vector<std::array<double, 6>> uv() const {
        std::vector<std::array<double, 6>> found(faces_.size());
        detail::check(cata_mesh_file_get_uv(handle_.get(), detail::first_of(found)));
        return found;
    }

    /// Normals: x, y, z at the corners of each face, NaN where it has none.
    std::vector<std::array<double, 9>> normals() const {
        std::vector<std::array<double, 9>> found(faces_.size());
        detail::check(cata_mesh_file_get_normals(handle_.get(), detail::first_of(found)));
        return found;
    }

    /// Colours: red, green, blue and opacity of each vertex.
    std::vector<std::array<double, 4>> colors() const {
        std::vector<std::array<double, 4>> found(vertices_.size());
        detail::check(cata_mesh_file_get_colors(handle_.get(), detail::first_of(found)));
        return found;
    }

    /// As uv() returns them, one for each face.
    void set_uv(const std::vector<std::array<double, 6>>& uv) {
        detail::require(uv.size() == faces_.size(), CATA_ERR_SHAPE,
                        "uv: must be one for each face");
        detail::check(cata_mesh_file_set_uv(handle_.get(), detail::first_of(uv)));
    }

    /// As normals() returns them, one for each face.
    void set_normals(const std::vector<std::array<double, 9>>& normals) {
        detail::require(normals.size() == faces_.size(), CATA_ERR_SHAPE,
                        "normals: must be one for each face");
        detail::check(cata_mesh_file_set_normals(handle_.get(), detail::first_of(normals)));
    }

    /// As colors() returns them, one for each vertex.
    void set_colors(const std::vector<std::array<double, 4>>& colors) {
        detail::require(colors.size() == vertices_.size(), CATA_ERR_SHAPE,
                        "colors: must be one for each vertex");
        detail::check(cata_mesh_file_set_colors(handle_.get(), detail::first_of(colors)));
    }

    /// The names of faces.
    face_names names(mesh_names kind) const {
        const auto value = static_cast<std::int32_t>(kind);
        std::size_t count = 0;
        detail::check(cata_mesh_file_names(handle_.get(), value, &count));
        face_names found;
        found.of_faces.resize(faces_.size());
        detail::check(cata_mesh_file_get_names(handle_.get(), value, found.of_faces.data()));
        for (std::size_t i = 0; i < count; ++i) {
            char text[longest];
            detail::check(cata_mesh_file_name(handle_.get(), value, i, sizeof text, text));
            found.names.emplace_back(text);
        }
        return found;
    }

    /// Replaces the names of faces; no names: there are none.
    void set_names(mesh_names kind, const face_names& names) {
        detail::require(names.names.empty() || names.of_faces.size() == faces_.size(),
                        CATA_ERR_SHAPE, "of_faces: must be one for each face");
        std::vector<const char*> texts;
        for (const std::string& name : names.names) {
            texts.push_back(name.c_str());
        }
        detail::check(cata_mesh_file_set_names(handle_.get(), static_cast<std::int32_t>(kind),
                                               texts.size(), texts.data(),
                                               names.of_faces.data()));
    }

    /// The functions on the vertices that the file has.
    std::vector<vertex_scalars> scalars() const {
        std::size_t count = 0;
        detail::check(cata_mesh_file_scalars(handle_.get(), &count));
        std::vector<vertex_scalars> found(count);
        for (std::size_t i = 0; i < count; ++i) {
            char text[longest];
            found[i].values.resize(vertices_.size());
            detail::check(cata_mesh_file_get_scalars(handle_.get(), i, sizeof text, text,
                                                     found[i].values.data()));
            found[i].name = text;
        }
        return found;
    }

    /// What the reader left out or replaced, or what the file that was written last does not hold.
    std::vector<std::string> notes() const {
        std::size_t count = 0;
        detail::check(cata_mesh_file_notes(handle_.get(), &count, nullptr));
        std::vector<std::string> found;
        for (std::size_t i = 0; i < count; ++i) {
            char text[longest];
            detail::check(cata_mesh_file_note(handle_.get(), i, sizeof text, text));
            found.emplace_back(text);
        }
        return found;
    }

    /// The handle, owned by this.
    const cata_mesh_file* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_mesh_file* handle) const noexcept { cata_mesh_file_free(handle); }
    };

    /// Room for a name or a note; longer ones are cut.
    static constexpr std::size_t longest = 4096;

    void take(cata_mesh_file* handle) {
        handle_.reset(handle);
        std::size_t n_vertices = 0, n_faces = 0;
        detail::check(cata_mesh_file_size(handle, &n_vertices, &n_faces));
        vertices_.resize(n_vertices);
        faces_.resize(n_faces);
        detail::check(
            cata_mesh_file_get(handle, detail::first_of(vertices_), detail::first_of(faces_)));
    }

    std::array<std::int32_t, 3> has() const {
        std::array<std::int32_t, 3> found{};
        detail::check(cata_mesh_file_has(handle_.get(), &found[0], &found[1], &found[2]));
        return found;
    }

    std::unique_ptr<cata_mesh_file, free> handle_;
    point_list vertices_;
    triangle_list faces_;
};

/// Which vertices are joined.
enum class weld_kind : std::int32_t {
    never = CATA_WELD_NEVER,
    exact = CATA_WELD_EXACT,
    within = CATA_WELD_WITHIN,
    seams = CATA_WELD_SEAMS,
};

/// The steps of a repair, by default none: the fields of cata_repair_params.
struct repair_options {
    /// Distance of weld_kind::within, in the unit of the mesh.
    double tolerance = 0.0;
    /// Components to keep, those with the most faces; 0: all.
    std::size_t keep_largest = 0;
    /// Components with less than this share of the area are left out.
    double drop_specks = 0.0;
    /// Holes of at most this many edges are filled.
    std::size_t fill_holes = 0;
    /// Whether all that follow are done, with weld_kind::seams unless weld says otherwise.
    bool everything = false;
    /// The vertices that are joined.
    weld_kind weld = weld_kind::never;
    /// Whether faces with the vertices of an earlier one are left out.
    bool drop_duplicates = false;
    /// Whether faces without area are removed.
    bool drop_degenerate = false;
    /// Whether vertices without a face are left out.
    bool compact = false;
    /// Whether the mesh is cut into a manifold.
    bool cut = false;
    /// Whether faces are flipped to agree with their neighbours, and to face outside.
    bool orient = false;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// What a step of a repair did: cata_repair_step.
struct repair_step {
    /// One of CATA_REPAIR_*.
    std::int32_t kind = 0;
    /// Number of vertices that joined others, were left out, or were split.
    std::size_t vertices = 0;
    /// Number of edges that were flipped or cut, or stay apart because more than two coincide.
    std::size_t edges = 0;
    /// Number of faces that were left out, are new, or were flipped.
    std::size_t faces = 0;
    /// Components that were left out, or holes that were filled.
    std::size_t parts = 0;
    /// Number of items that could not be repaired, or lost their colour.
    std::size_t left = 0;
    /// A line of text that describes the step.
    std::string text;
};

/// A repaired mesh, and what was done.
struct repaired {
    /// The mesh with its attributes.
    mesh_file file;
    /// For each vertex of the input the lowest of the result that comes from it; UINT32_MAX where
    /// it was left out.
    std::vector<std::uint32_t> vertices;
    /// Steps, in the order in which they were taken.
    std::vector<repair_step> steps;
    /// Whether any changed the mesh.
    bool changed = false;
};

/// A mesh after the steps of a repair: cata_repair_new.
inline repaired repair(const mesh_file& file, const repair_options& how) {
    cata_repair_params params;
    detail::check(cata_repair_params_init(&params, sizeof params));
    params.tolerance = how.tolerance;
    params.keep_largest = how.keep_largest;
    params.drop_specks = how.drop_specks;
    params.fill_holes = how.fill_holes;
    params.everything = how.everything ? 1 : 0;
    params.weld = static_cast<std::int32_t>(how.weld);
    params.drop_duplicates = how.drop_duplicates ? 1 : 0;
    params.drop_degenerate = how.drop_degenerate ? 1 : 0;
    params.compact = how.compact ? 1 : 0;
    params.cut = how.cut ? 1 : 0;
    params.orient = how.orient ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    cata_repair* made = nullptr;
    watcher.finish(cata_repair_new(file.get(), &params, &made));
    const std::unique_ptr<cata_repair, void (*)(cata_repair*)> handle(made, cata_repair_free);
    cata_mesh_file* mesh = nullptr;
    detail::check(cata_repair_file(made, &mesh));
    repaired found{mesh_file(mesh), std::vector<std::uint32_t>(file.vertices().size()), {}, false};
    detail::check(cata_repair_vertices(made, found.vertices.data()));
    std::size_t count = 0;
    std::int32_t changed = 0;
    detail::check(cata_repair_steps(made, &count, &changed));
    found.changed = changed != 0;
    found.steps.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        repair_step& step = found.steps[i];
        char text[512];
        detail::check(cata_repair_step(made, i, &step.kind, &step.vertices, &step.edges,
                                       &step.faces, &step.parts, &step.left));
        detail::check(cata_repair_step_text(made, i, sizeof text, text));
        step.text = text;
    }
    return found;
}

/// Why a mesh needs a repair that has a single sensible result; empty: it does not.
inline std::string repair_needed(const mesh_view& mesh) {
    std::int32_t needed = 0;
    char text[512];
    detail::check(cata_repair_needed(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                     &needed, sizeof text, text));
    return text;
}

}  // namespace catamaran

#endif
