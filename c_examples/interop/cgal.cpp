// A mesh of CGAL: eigenvalues of its Laplacian from its own points, and a coarser mesh of CGAL.

#include <catamaran/cgal.hpp>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/boost/graph/generators.h>
#include <CGAL/boost/graph/helpers.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

using Point = CGAL::Simple_cartesian<double>::Point_3;

int main() {
    try {
        CGAL::Surface_mesh<Point> sphere;
        CGAL::make_icosahedron(sphere, Point(0, 0, 0), 1.0);
        const auto borrowed = catamaran::borrow(sphere);
        const catamaran::decimation fine(borrowed.mesh(), 2000);
        auto finer = catamaran::surface_mesh<Point>(fine.mesh());
        for (const auto vertex : finer.vertices()) {
            const auto from_centre = finer.point(vertex) - CGAL::ORIGIN;
            finer.point(vertex) =
                CGAL::ORIGIN + from_centre / std::sqrt(from_centre.squared_length());
        }
        // The sphere's are 0, 2 (three times) and 6.
        const auto points = catamaran::borrow(finer);
        const auto pairs = catamaran::eigs(points.mesh(), 5);
        std::cout << "eigenvalues " << pairs.values[1] << " and " << pairs.values[4] << '\n';

        const catamaran::decimation small(points.mesh(), 100);
        const auto coarse = catamaran::surface_mesh<Point>(small.mesh());
        std::cout << coarse.num_vertices() << " vertices, closed: " << CGAL::is_closed(coarse)
                  << '\n';
        return borrowed.shares_vertices() && coarse.num_vertices() == 100 &&
                       CGAL::is_closed(coarse) && std::abs(pairs.values[1] - 2) < 0.02
                   ? EXIT_SUCCESS
                   : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
