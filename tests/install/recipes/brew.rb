# Run the formula of a recipe as Homebrew would, in the source: brew.rb FORMULA PREFIX CMAKE-ARGUMENT...
require "pathname"
require "tmpdir"

$prefix = Pathname.new(ARGV[1])
$arguments = ARGV[2..]
$source = Dir.pwd

module OS
  def self.mac? = false
end

# What a formula may say, as far as that of planish does.
class Formula
  %i[desc homepage url sha256 license uses_from_macos].each { |name| define_singleton_method(name) { |*| nil } }
  define_singleton_method(:depends_on) { |_| nil }
  define_singleton_method(:on_macos) { |&_| nil }
  define_singleton_method(:test) { |&block| @@test = block }
  def include = $prefix/"include"
  def lib = $prefix/"lib"
  def bin = $prefix/"bin"
  def testpath = Pathname.new(Dir.pwd)
  def version = ENV.fetch("PLANISH_VERSION")
  def std_cmake_args = ["-DCMAKE_INSTALL_PREFIX=#{$prefix}", "-DCMAKE_INSTALL_LIBDIR=lib", *$arguments]
  def system(*command) = Kernel.system({ "LD_LIBRARY_PATH" => lib.to_s }, *command) || abort("failed: #{command.join(" ")}")
  def shell_output(command) = `#{command}`
  def assert_match(expected, text) = text.include?(expected) || abort("#{expected} is not in #{text}")
  def run_test = Dir.mktmpdir { |folder| Dir.chdir(folder) { instance_exec(&@@test) } }
end
def ENV.cc = "cc"

load ARGV[0]
formula = Planish.new
formula.install
formula.run_test
