// A program in C++: finds the library by CMake; the header is C++, too.
#include <planish/planish.h>
#ifdef WITH_IO
#include <planish/planish_io.h>
#endif

#include <cstdio>
#include <vector>

int main(int argc, char **argv) {
    std::vector<double> xy = {0, 0, 1, 0, 1, 1, 0, 1, 0.7, 0.6};
    const std::vector<int64_t> triangles = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    planish_mesh mesh{};
    mesh.dim = 2;
    mesh.n_nodes = 5;
    mesh.n_elements = 4;
    mesh.coordinates = xy.data();
    mesh.elements64 = triangles.data();
    planish_plan *plan = nullptr;
    planish_result result;
    planish_error error;
    planish_options options;
    planish_options_init(&options);
    if (planish_plan_create(&mesh, &options, &plan, &error) ||
        planish_smooth(plan, xy.data(), &options, &result, &error)) {
        std::fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    planish_plan_destroy(plan);
    std::printf("RMS %.4f -> %.4f\n", result.objective_before, result.objective);
#ifdef WITH_IO
    planish_file *file = nullptr;
    if (argc < 2 || planish_file_open(argv[1], nullptr, 1, &file, &error))
        return 1;
    std::printf("%lld elements\n", static_cast<long long>(planish_file_mesh(file).n_elements));
    planish_file_close(file);
#else
    (void)argc;
    (void)argv;
#endif
    return !(result.objective < result.objective_before);
}
