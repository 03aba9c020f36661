// after_tetgen: mesh a closed surface with TetGen's library, smooth its arrays in place, write them.
//
//   c++ after_tetgen.cpp -o after_tetgen $(pkg-config --cflags --libs planish) -ltet
//   ./after_tetgen IN.stl OUT [SWITCHES]              writes OUT.node and OUT.ele
#include <planish/planish.h>
#include <tetgen.h>

#include <chrono>
#include <cstdio>
#include <string>

static double now() {
    using clock = std::chrono::steady_clock;
    return std::chrono::duration<double>(clock::now().time_since_epoch()).count();
}

static void show(const char *when, const planish_quality &q, double seconds) {
    std::printf("%-7s %ld elements, worst RR %.4g, angles %.4g to %.5g, RMS of RR %.4f, %.3f s\n",
                when, static_cast<long>(q.n_elements), q.max_radius_ratio, q.min_angle_deg,
                q.max_angle_deg, q.rms_radius_ratio, seconds);
}

int main(int argc, char **argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: after_tetgen IN.stl OUT [SWITCHES]\n");
        return 64;
    }
    // z: numbers start at 0, n: neighbours, Q: quiet.
    std::string switches = std::string(argc > 3 ? argv[3] : "pqO9/7") + "znQ";
    tetgenbehavior behavior;
    tetgenio in, out;
    if (!behavior.parse_commandline(&switches[0]) || !in.load_stl(argv[1])) {
        std::fprintf(stderr, "after_tetgen: %s cannot be read\n", argv[1]);
        return 2;
    }
    double begin = now();
    try {
        tetrahedralize(&behavior, &in, &out);
    } catch (int code) {
        std::fprintf(stderr, "after_tetgen: TetGen failed with code %d\n", code);
        return 2;
    }
    const double meshing = now() - begin;

    // TetGen's arrays are what planish takes: double [n][3], int [m][4].
    planish_mesh mesh{};
    mesh.dim = 3;
    mesh.n_nodes = out.numberofpoints;
    mesh.n_elements = out.numberoftetrahedra;
    mesh.coordinates = out.pointlist;
    mesh.elements = out.tetrahedronlist;
    mesh.neighbours = out.neighborlist;
    planish_plan *plan = nullptr;
    planish_quality before, after;
    planish_error error;
    planish_measure_mesh(&mesh, nullptr, &before, &error);
    begin = now();
    if (planish_plan_create(&mesh, nullptr, &plan, &error) ||
        planish_smooth(plan, out.pointlist, nullptr, nullptr, &error)) {
        std::fprintf(stderr, "after_tetgen: %s\n", error.text);
        return 2;
    }
    const double smoothing = now() - begin;
    planish_measure(plan, out.pointlist, &after, &error);
    planish_plan_destroy(plan);
    show("before", before, meshing);
    show("after", after, smoothing);
    out.firstnumber = 0; // as the elements were numbered
    out.save_nodes(argv[2]);
    out.save_elements(argv[2]);
    return 0;
}
