# Homebrew: program, libraries and Python module. Untested in its own system; planish was never built on macOS.
class Planish < Formula
  desc "Smooth and untangle meshes"
  homepage "@HOMEPAGE@"
  url "@URL@"
  sha256 "@SHA256@"
  license "BSD-3-Clause"

  depends_on "cmake" => :build
  depends_on "cjson"
  depends_on "hdf5"
  depends_on "hwloc"
  depends_on "lz4"
  depends_on "xz"

  uses_from_macos "expat"
  uses_from_macos "zlib"

  on_macos do
    depends_on "libomp"
  end

  def install
    args = %w[-DPLANISH_TESTS=OFF -DPLANISH_BENCH=OFF -DPLANISH_PETSC=OFF]
    args << "-DOpenMP_ROOT=#{Formula["libomp"].opt_prefix}" if OS.mac?
    system "cmake", "-S", ".", "-B", "build", *args, *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    (testpath/"test.c").write <<~C
      #include <planish/planish.h>
      int main(void) {
        double xy[] = {0, 0, 1, 0, 1, 1, 0, 1, 0.8, 0.7};
        const int32_t triangles[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
        const planish_mesh mesh = {
          .dim = 2, .n_nodes = 5, .n_elements = 4, .coordinates = xy, .elements = triangles};
        planish_plan *plan = 0;
        int status = planish_plan_create(&mesh, 0, &plan, 0);
        if (!status)
          status = planish_smooth(plan, xy, 0, 0, 0);
        planish_plan_destroy(plan);
        return status || xy[8] > 0.6;
      }
    C
    system ENV.cc, "test.c", "-I#{include}", "-L#{lib}", "-lplanish", "-o", "test"
    system "./test"
    assert_match version.to_s, shell_output("#{bin}/planish --version")
  end
end
