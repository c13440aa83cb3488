// One decimation of a mesh by CGAL's edge collapse (Debian: libcgal-dev).
//
//     cgal_collapse INPUT.ply FACES OUTPUT.ply     prints seconds and bytes of the call alone; reading is not counted
//
// The default cost and placement: Lindstrom and Turk, 1998.

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh/IO/PLY.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

namespace simplification = CGAL::Surface_mesh_simplification;
using Mesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

static long resident() {
    long pages = 0, all = 0;
    std::ifstream("/proc/self/statm") >> all >> pages;
    return pages * sysconf(_SC_PAGESIZE);
}

int main(int count, char** arguments) {
    if (count != 4) {
        std::cerr << "cgal_collapse INPUT.ply FACES OUTPUT.ply\n";
        return 2;
    }
    Mesh mesh;
    std::ifstream input(arguments[1], std::ios::binary);
    if (!CGAL::IO::read_PLY(input, mesh)) {
        std::cerr << arguments[1] << ": not a mesh that CGAL takes\n";
        return 1;
    }
    // A closed mesh has three edges for two faces.
    const std::size_t edges = std::strtoull(arguments[2], nullptr, 10) * 3 / 2;
    const long before = resident();
    const auto start = std::chrono::steady_clock::now();
    simplification::edge_collapse(mesh, simplification::Count_stop_predicate<Mesh>(edges));
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    mesh.collect_garbage();
    std::ofstream output(arguments[3], std::ios::binary);
    CGAL::IO::set_binary_mode(output);
    if (!CGAL::IO::write_PLY(output, mesh)) return 1;
    std::cout << seconds.count() << ' ' << usage.ru_maxrss * 1024 - before << '\n';
}
