// after_cgal: mesh an implicit domain with CGAL's Mesh_3, smooth it, put the points back.
//
//   c++ -O2 after_cgal.cpp -o after_cgal $(pkg-config --cflags --libs planish) -lgmp -lmpfr
//   ./after_cgal OUT.mesh [CELL_SIZE]
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Real_timer.h>
#include <CGAL/make_mesh_3.h>
#include <planish/planish.h>
#include <cstdio>
#include <fstream>
#include <unordered_map>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Vertex = Triangulation::Vertex_handle;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

static void show(const char *when, const planish_quality &q, double seconds) {
    std::printf("%-7s %ld elements, worst RR %.4g, angles %.4g to %.5g, RMS of RR %.4f, %.3f s\n", when,
                static_cast<long>(q.n_elements), q.max_radius_ratio, q.min_angle_deg, q.max_angle_deg,
                q.rms_radius_ratio, seconds);
}

static double torus(const Kernel::Point_3 &p) {
    const double r = std::hypot(p.x(), p.y()) - 1;
    return r * r + p.z() * p.z() - 0.16;
}

int main(int argc, char **argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: after_cgal OUT.mesh [CELL_SIZE]\n"), 64;
    const double size = argc > 2 ? std::atof(argv[2]) : 0.12;
    CGAL::Real_timer timer;
    timer.start();
    const Domain domain = Domain::create_implicit_mesh_domain(
        torus, Kernel::Sphere_3(CGAL::ORIGIN, 4), CGAL::parameters::relative_error_bound = 1e-5);
    const Criteria criteria(CGAL::parameters::facet_size = size, CGAL::parameters::cell_size = size,
                            CGAL::parameters::facet_distance = size / 10);
    Complex complex = CGAL::make_mesh_3<Complex>(domain, criteria); // perturbs and exudes slivers
    const double meshing = timer.time();

    std::unordered_map<Vertex, int32_t> number;
    std::vector<Vertex> vertices;
    std::vector<double> xyz;
    std::vector<int32_t> elements; // of 4 vertices each, by their numbers
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell)
        for (int j = 0; j < 4; j++) {
            if (number.emplace(cell->vertex(j), static_cast<int32_t>(vertices.size())).second)
                vertices.push_back(cell->vertex(j));
            elements.push_back(number[cell->vertex(j)]);
        }
    for (auto vertex : vertices)
        xyz.insert(xyz.end(), {vertex->point().x(), vertex->point().y(), vertex->point().z()});
    const planish_mesh mesh{3, static_cast<int64_t>(vertices.size()),
                            static_cast<int64_t>(elements.size() / 4), xyz.data(), elements.data()};
    planish_plan *plan = nullptr;
    planish_quality before, after;
    planish_error error;
    planish_measure_mesh(&mesh, nullptr, &before, &error);
    timer.reset();
    if (planish_plan_create(&mesh, nullptr, &plan, &error) ||
        planish_smooth(plan, xyz.data(), nullptr, nullptr, &error))
        return std::fprintf(stderr, "after_cgal: %s\n", error.text), 2;
    timer.stop();
    show("before", before, meshing);
    planish_measure(plan, xyz.data(), &after, &error);
    show("after", after, timer.time());
    planish_plan_destroy(plan);
    for (size_t i = 0; i < vertices.size(); i++) // no longer a Delaunay triangulation then
        vertices[i]->set_point({Kernel::Point_3(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]), 0});
    std::ofstream out(argv[1]);
    complex.output_to_medit(out);
    return out ? 0 : 2;
}
