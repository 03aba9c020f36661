/* Any bytes as the tags of groups, of a small mesh in one of several formats: they are understood
 * or refused, and what is held and asked for is the same when it is asked for again.
 */
#include "fuzz_bytes.h"

#include "io/file/file.h"

enum { MOST_TAGS = 8, N_FORMATS = 3 };

static const struct {
    const io_format *format;
    const char *text;
} meshes[N_FORMATS] = {
    {&io_format_gmsh,
     "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 7 \"wall\"\n3 9 \"all\"\n"
     "3 7 \"a=b\"\n$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1.5\n"
     "$EndNodes\n$Elements\n4\n1 2 2 7 1 1 2 3\n2 4 2 9 1 1 2 3 4\n3 4 2 7 2 2 3 4 5\n"
     "4 1 2 0 1 4 5\n$EndElements\n"},
    {&io_format_medit,
     "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 1\n1 0 0 2\n0 1 0 0\n0 0 1 0\n"
     "1 1 1.5 -3\nTetrahedra\n2\n1 2 3 4 1\n2 3 4 5 2\nTriangles\n1\n1 2 3 7\nEnd\n"},
    {&io_format_abaqus,
     "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1.5\n*ELEMENT,TYPE=C3D4,ELSET=A\n1,1,2,3,4\n"
     "*ELEMENT,TYPE=C3D4,ELSET=\"b c\"\n2,2,3,4,5\n*NSET,NSET=N\n1,5\n"}};

static planish_file *open_mesh(int i) {
    planish_file *file;
    planish_error error;
    if (io_file_from_memory(meshes[i].format, "mesh", meshes[i].text,
                            (int64_t)strlen(meshes[i].text), 1, &file, &error))
        fuzz_require(0, error.text);
    return file;
}

/** Words, each ended by a '\0' or the input's end, in blocks of their own. */
static int take_tags(fuzz_bytes *bytes, const char **tag) {
    int n = take_below(bytes, MOST_TAGS + 1);
    for (int i = 0; i < n; i++) {
        const size_t left = (size_t)(bytes->end - bytes->at);
        const uint8_t *zero = left ? memchr(bytes->at, '\0', left) : NULL;
        const size_t length = zero ? (size_t)(zero - bytes->at) : left;
        char *copy = malloc(length + 1);
        fuzz_require(copy != NULL, "memory");
        if (length > 0)
            memcpy(copy, bytes->at, length);
        copy[length] = '\0';
        tag[i] = copy;
        bytes->at += length + (zero != NULL);
    }
    return n;
}

static int told(int status, const planish_error *error) {
    if (status)
        fuzz_require(error->code == status && error->text[0] &&
                         strlen(error->text) < sizeof error->text,
                     "a failure has a code and a text");
    return status == 0;
}

static void check_constraints(const planish_file *file, const planish_hold *hold) {
    const planish_mesh mesh = planish_file_mesh(file);
    uint8_t constraint[2][8];
    planish_error error;
    const int status = planish_file_constraints(file, hold, constraint[0], &error);
    if (!told(status, &error))
        return;
    fuzz_require(planish_file_constraints(file, hold, constraint[1], NULL) == 0 &&
                     memcmp(constraint[0], constraint[1], (size_t)mesh.n_nodes) == 0,
                 "the same nodes are held again");
    for (int64_t i = 0; i < mesh.n_nodes; i++)
        fuzz_require(constraint[0][i] <= PLANISH_CONSTRAINT_FIXED, "nodes are held or not");
    const planish_surface surface = planish_file_surface(file, hold);
    double direction[24];
    fuzz_require(surface.n_facets >= 0 && surface.n_edges >= 0, "the surface has its counts");
    planish_mesh held = mesh;
    held.constraint = constraint[0];
    told(planish_find_slides(&held, &surface, 1, constraint[1], direction, NULL, &error), &error);
}

static void check_volumes(fuzz_bytes *bytes, const planish_file *file, const char *const *tag,
                          int n) {
    double value[MOST_TAGS], least[4] = {-1, -1, -1, -1}, largest = 0;
    planish_error error;
    for (int i = 0; i < n; i++) {
        value[i] = 1e-3 + fabs(take_finite(bytes));
        largest = fmax(largest, value[i]);
    }
    const int status = planish_file_min_volumes(file, tag, value, n, least, &error);
    for (int64_t i = 0; i < planish_file_mesh(file).n_elements; i++)
        fuzz_require(status ? least[i] == -1 : least[i] >= 0 && least[i] <= largest,
                     "minimum volumes are those given");
    told(status, &error);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_bytes bytes = {data, data + size};
    const char *tag[2][MOST_TAGS];
    planish_file *file = open_mesh(take_below(&bytes, N_FORMATS));
    const int flags = take_byte(&bytes);
    const int n = take_tags(&bytes, tag[0]), n_slide = take_tags(&bytes, tag[1]);
    const planish_hold hold = {.tags = tag[0],
                               .n_tags = n,
                               .ignore_regions = flags & 1,
                               .ignore_marked = flags & 2,
                               .slide = flags & 4,
                               .slide_tags = tag[1],
                               .n_slide_tags = n_slide};
    check_constraints(file, &hold);
    check_volumes(&bytes, file, tag[0], n);
    for (int i = 0; i < n; i++)
        free((void *)(uintptr_t)tag[0][i]);
    for (int i = 0; i < n_slide; i++)
        free((void *)(uintptr_t)tag[1][i]);
    planish_file_close(file);
    return 0;
}
