# Recipe for Spack (https://spack.readthedocs.io/en/latest/packaging_guide.html): address and hash are those of the released archive.
from spack.package import *


class Surveymc(CMakePackage):
    """Monte-Carlo research workbench for wellbore directional surveying: draws the errors of survey tools, predicts the same
    analytically, and writes both side by side with a verdict in every row."""

    homepage = "https://example.invalid/surveymc"
    url = "https://example.invalid/surveymc-0.2.0.tar.gz"

    maintainers("put-your-name-here")
    license("MIT", checked_by="put-your-name-here")

    version("0.2.0", sha256="0000000000000000000000000000000000000000000000000000000000000000")

    variant("mpi", default=False, description="build surveymc-mpi")
    variant("python", default=True, description="plots, reports and the Python package")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("boost@1.74:")
    depends_on("cli11")
    depends_on("eigen@3.4:")
    depends_on("fmt")
    depends_on("geographiclib")
    depends_on("hdf5+hl~mpi", when="~mpi")
    depends_on("hdf5+hl", when="+mpi")
    depends_on("mpi", when="+mpi")
    depends_on("nlopt")
    depends_on("tomlplusplus")
    depends_on("xxhash")
    with when("+python"):
        depends_on("python@3.11:", type="run")
        depends_on("py-h5py@3.7:", type="run")
        depends_on("py-jinja2@3:", type="run")
        depends_on("py-matplotlib@3.6:", type="run")
        depends_on("py-numpy", type="run")
        depends_on("py-pandas@1.5:", type="run")
        depends_on("py-xarray@2023.1:", type="run")
        depends_on("py-xxhash@3:", type="run")

    conflicts("%gcc@:11", msg="surveymc needs C++20")

    def cmake_args(self):
        return [
            self.define("SURVEYMC_TESTS", False),
            self.define("SURVEYMC_BENCHMARKS", False),
            self.define_from_variant("SURVEYMC_MPI", "mpi"),
        ]

    def setup_run_environment(self, env):
        env.prepend_path("PYTHONPATH", join_path(self.prefix, "lib", "python3", "dist-packages"))

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        program = Executable(self.prefix.bin.surveymc)
        with working_dir("test-of-install", create=True):
            program("new", "position_covariance", "-o", "well.toml")
            program("run", "well.toml")
            program("rerun", "results/well.h5")
