#include <pybind11/stl.h>

#include "bindings.h"

PYBIND11_MODULE(_core, module)
{
    using namespace lumisweep::python;
    module.doc() = "Unbiased volume rendering under natural light: the library's public API, with NumPy arrays.";
    module.attr("__version__") = lumisweep::version();
    py::register_exception<lumisweep::Error>(module, "Error", PyExc_RuntimeError).doc() =
        "What the library refuses: one line that says what, where, and the mend.";
    watch_interpreter();
    bind_volume(module);
    bind_transfer_function(module);
    bind_environment(module);
    bind_settings(module);
    bind_image(module);
    bind_visibility(module);
    bind_sampler(module);
    bind_session(module);
    module.def("available_isas", &lumisweep::available_isas,
               "Instruction sets that this build has and this machine runs, best first.");
}
