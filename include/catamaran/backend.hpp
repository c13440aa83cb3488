// BLAS libraries as back ends.

#ifndef CATAMARAN_BACKEND_HPP
#define CATAMARAN_BACKEND_HPP

#include "core.hpp"

#include <memory>
#include <string>

namespace catamaran {

/// A BLAS library that computes the small products. Movable, not copyable.
class backend {
public:
    /// Loads a shared library with the CBLAS interface.
    static backend load(const std::string& path) {
        cata_backend* handle = nullptr;
        detail::check(cata_backend_load(path.c_str(), &handle));
        return backend(handle);
    }

    /// The OpenBLAS that the library was linked with; throws without CATA_CAP_OPENBLAS.
    static backend openblas() {
        cata_backend* handle = nullptr;
        detail::check(cata_backend_openblas(&handle));
        return backend(handle);
    }

    /// A short name, or the file name of a loaded library.
    std::string name() const { return cata_backend_name(handle_.get()); }

    /// The handle, for calls of C.
    const cata_backend* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_backend* handle) const noexcept { cata_backend_free(handle); }
    };

    explicit backend(cata_backend* handle) noexcept : handle_(handle) {}

    std::unique_ptr<cata_backend, free> handle_;
};

}  // namespace catamaran

#endif
