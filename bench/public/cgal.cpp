// cgal: implicit domains, meshed by CGAL's Mesh_3, as a file of Medit.
//
//   c++ -O2 cgal.cpp -o cgal -lgmp -lmpfr
//   ./cgal OUT.mesh KIND PARAMETER CELL_SIZE OPTIMISE     KIND: any whole number; PARAMETER: from 0 to 1
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

static int kind;
static double parameter;

static double sphere(double x, double y, double z, double r) {
    return x * x + y * y + z * z - r * r;
}

// Negative inside.
static double shape(const Kernel::Point_3 &p) {
    const double x = p.x(), y = p.y(), z = p.z(), ring = std::hypot(x, y) - 1;
    switch (kind % 4) {
    case 0: return ring * ring + z * z - (0.1 + 0.1 * parameter);
    case 1: return std::min(sphere(x - 0.4 - 0.3 * parameter, y, z, 0.7), sphere(x + 0.4, y, z, 0.8));
    case 2: return std::max(sphere(x, y, z, 1), -sphere(x - 0.5, y, z, 0.4 + 0.3 * parameter));
    default: return std::pow(x, 4) + std::pow(y, 4) + std::pow(z, 4) - x * x - y * y - z * z + 0.3 + 0.1 * parameter;
    }
}

int main(int argc, char **argv) {
    if (argc != 6) return std::fprintf(stderr, "usage: cgal OUT.mesh KIND PARAMETER CELL_SIZE OPTIMISE\n"), 64;
    kind = std::atoi(argv[2]);
    parameter = std::atof(argv[3]);
    const double size = std::atof(argv[4]);
    const Domain domain = Domain::create_implicit_mesh_domain(shape, Kernel::Sphere_3(CGAL::ORIGIN, 4),
                                                              CGAL::parameters::relative_error_bound = 1e-5);
    const Criteria criteria(CGAL::parameters::facet_size = size, CGAL::parameters::cell_size = size,
                            CGAL::parameters::facet_distance = size / 8);
    const Complex complex = std::atoi(argv[5])
        ? CGAL::make_mesh_3<Complex>(domain, criteria) // perturbs and exudes slivers
        : CGAL::make_mesh_3<Complex>(domain, criteria, CGAL::parameters::no_perturb(), CGAL::parameters::no_exude());
    std::ofstream out(argv[1]);
    complex.output_to_medit(out);
    return out ? 0 : 2;
}
