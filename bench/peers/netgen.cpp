// netgen: Netgen's Mesh::ImproveMesh, its pass over the inner nodes, on a mesh in a binary file.
//
//   netgen IN OUT PASSES
//
// IN (peers.py writes it): three int64 counts, of points, triangles and tetrahedra; the points,
// double[n][3]; the triangles, int32[n][3], and the tetrahedra, int32[n][4], from 1. Nodes of
// triangles stay. OUT: points and tetrahedra, in the same way, without counts. Standard output: the
// seconds of the passes alone, wall and CPU.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <vector>

#include <meshing.hpp>
namespace nglib { // where the library has what this header declares
#include <nglib.h>
}

namespace {

template <typename T> std::vector<T> take(std::ifstream &in, int64_t count) {
    std::vector<T> values(static_cast<size_t>(count));
    in.read(reinterpret_cast<char *>(values.data()), count * static_cast<int64_t>(sizeof(T)));
    if (!in) {
        std::fprintf(stderr, "netgen: the input is missing or too short\n");
        std::exit(2);
    }
    return values;
}

nglib::Ng_Mesh *read_mesh(const char *path) {
    std::ifstream in(path, std::ios::binary);
    const auto counts = take<int64_t>(in, 3);
    auto points = take<double>(in, 3 * counts[0]);
    auto triangles = take<int32_t>(in, 3 * counts[1]);
    auto tetrahedra = take<int32_t>(in, 4 * counts[2]);
    nglib::Ng_Mesh *mesh = nglib::Ng_NewMesh();
    for (size_t i = 0; i < points.size(); i += 3)
        nglib::Ng_AddPoint(mesh, &points[i]);
    for (size_t i = 0; i < triangles.size(); i += 3)
        nglib::Ng_AddSurfaceElement(mesh, nglib::NG_TRIG, &triangles[i]);
    for (size_t i = 0; i < tetrahedra.size(); i += 4)
        nglib::Ng_AddVolumeElement(mesh, nglib::NG_TET, &tetrahedra[i]);
    return mesh;
}

void write_mesh(nglib::Ng_Mesh *mesh, const char *path) {
    std::ofstream out(path, std::ios::binary);
    for (int i = 1; i <= nglib::Ng_GetNP(mesh); i++) {
        double x[3];
        nglib::Ng_GetPoint(mesh, i, x);
        out.write(reinterpret_cast<const char *>(x), sizeof x);
    }
    for (int i = 1; i <= nglib::Ng_GetNE(mesh); i++) {
        int32_t nodes[4];
        nglib::Ng_GetVolumeElement(mesh, i, nodes);
        out.write(reinterpret_cast<const char *>(nodes), sizeof nodes);
    }
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: netgen IN OUT PASSES\n");
        return 64;
    }
    nglib::Ng_Init();
    netgen::printmessage_importance = 0;
    nglib::Ng_Mesh *mesh = read_mesh(argv[1]);
    const netgen::MeshingParameters defaults;
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    for (int pass = 0; pass < std::atoi(argv[3]); pass++)
        reinterpret_cast<netgen::Mesh *>(mesh)->ImproveMesh(defaults);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
    std::printf("%.6f %.6f\n", seconds.count(), double(std::clock() - cpu) / CLOCKS_PER_SEC);
    write_mesh(mesh, argv[2]);
    return 0;
}
