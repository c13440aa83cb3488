// Catamaran from C++17: RAII and exceptions over catamaran.h, header only.
//
// Nothing here adds a rule of its own: see catamaran.h for what the functions compute and promise.

#ifndef CATAMARAN_HPP
#define CATAMARAN_HPP

#if __cplusplus < 201703L
#error "catamaran.hpp needs C++17: compile with -std=c++17 or later"
#else

#include "catamaran/core.hpp"
#include "catamaran/backend.hpp"
#include "catamaran/ata.hpp"
#include "catamaran/gram.hpp"
#include "catamaran/tables.hpp"
#include "catamaran/accumulator.hpp"
#include "catamaran/cholesky.hpp"
#include "catamaran/meshes.hpp"
#include "catamaran/surfaces.hpp"
#include "catamaran/eigs.hpp"
#include "catamaran/laplacians.hpp"
#include "catamaran/distances.hpp"
#include "catamaran/decimation.hpp"
#include "catamaran/curves.hpp"
#include "catamaran/regions.hpp"
#include "catamaran/maps.hpp"
#include "catamaran/descriptors.hpp"
#include "catamaran/unions.hpp"
#include "catamaran/plants.hpp"
#include "catamaran/slime.hpp"
#include "catamaran/newton.hpp"
#include "catamaran/devices.hpp"

#endif

#endif
