/* The arithmetic of bands in one pass over its arrays: the twin of arithmetic.py, which has the
 * reasons and does whatever a pass finds rare (infinities, denormal products, divisors near zero).
 *
 * Each pass takes bands or arrays and returns a band or arrays, or None where the NumPy code must do
 * it. Both give the same numbers; the sign of a zero bound means nothing and may differ. */

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <structmember.h>
#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#include <numpy/arrayobject.h>
#include <numpy/arrayscalars.h>

#include <fenv.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "rounding.h"
#include "operands.h"
#include "objects.h"
#include "values.h"
#include "pass.h"
#include "sums.h"
#include "totals.h"
#include "products.h"
#include "quotients.h"
#include "bounds.h"
#include "mixes.h"

/* Changes with what Python expects of the passes; the same number stands in compiled.py. */
#define INTERFACE 7

#define METHOD(name, function) \
    {#name, (PyCFunction)(void (*)(void))function, METH_FASTCALL, NULL}

static PyMethodDef methods[] = {
    METHOD(use_bands, use_bands), METHOD(add, add), METHOD(subtract, subtract),
    METHOD(sum_last, sum_last), METHOD(multiply, multiply), METHOD(square, square),
    METHOD(divide, divide), METHOD(inversesqrt, inversesqrt), METHOD(sqrt, square_root),
    METHOD(round_outward, outward),
    METHOD(cut_to_ends, within_ends), {0}};

static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "_kernels", NULL, -1, methods};

/* Whether the compiler left the rounding direction alone. */
static int rounds_outward(void)
{
    double a[4] = {1.0, -1.0, 1.0, -1.0}, b[4] = {0x1p-80, 0x1p-80, -0x1p-80, -0x1p-80};
    double lo[4], hi[4], low[4], high[4];
    sum(4, a, a, b, b, lo, hi);
    narrow(4, 1, lo, hi, low, high);
    double next = 0x1p-23, before = 0x1p-24;
    return low[0] == 1.0 && high[0] == 1.0 + next && low[1] == -1.0 && high[1] == before - 1.0
        && low[2] == 1.0 - before && high[2] == 1.0 && low[3] == -1.0 - next && high[3] == -1.0
        && hi[1] == lo[2] && hi[0] == lo[3];
}

PyMODINIT_FUNC PyInit__kernels(void)
{
    import_array();
    if (!rounds_outward()) {
        PyErr_SetString(PyExc_ImportError, "this compiler ignores the rounding direction");
        return NULL;
    }
    PyObject *made = PyModule_Create(&module);
    if (made && PyModule_AddIntConstant(made, "INTERFACE", INTERFACE)) Py_CLEAR(made);
    return made;
}
