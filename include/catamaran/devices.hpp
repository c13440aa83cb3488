// OpenCL devices.

#ifndef CATAMARAN_DEVICES_HPP
#define CATAMARAN_DEVICES_HPP

#include "core.hpp"

namespace catamaran {

/// What a device is.
enum class device_kind : std::int32_t {
    cpu = CATA_DEVICE_CPU,
    gpu = CATA_DEVICE_GPU,
    other = CATA_DEVICE_OTHER,
};

/// An OpenCL device.
struct device {
    /// In UTF-8, cut to 255 bytes.
    std::string name;
    /// Processor, graphics card or anything else.
    device_kind kind = device_kind::other;
};

/// The OpenCL devices of this machine, at least one.
inline std::vector<device> devices() {
    std::size_t count = 0;
    detail::check(cata_device_count(&count));
    std::vector<device> found(count);
    for (std::size_t i = 0; i < count; ++i) {
        char name[256];
        std::int32_t kind = 0;
        detail::check(cata_device_name(i, sizeof name, name));
        detail::check(cata_device_kind(i, &kind));
        found[i] = {name, static_cast<device_kind>(kind)};
    }
    return found;
}

}  // namespace catamaran

#endif
