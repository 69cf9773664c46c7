/* Comparisons of two bands: true, false or undecided, value by value. */

#ifndef SHADERLAB_COMPARISONS_H
#define SHADERLAB_COMPARISONS_H

LOOP void compare(
    npy_intp count, const Value *a, const Value *b, npy_bool *restrict less,
    npy_bool *restrict not_less)
{
    const double *a_lo = a->settled_low, *a_hi = a->settled_high;
    const double *b_lo = b->settled_low, *b_hi = b->settled_high;
    for (npy_intp i = 0; i < count; i++) {
        less[i] = a_hi[i] < b_lo[i];
        not_less[i] = a_lo[i] >= b_hi[i];
    }
}

static PyArrayObject *new_flags(const Shape *shape)
{
    return (PyArrayObject *)PyArray_SimpleNew(shape->ndim, (npy_intp *)shape->dims, NPY_BOOL);
}

/* The truth of a < b, or of its opposite, of bands that are no NaN anywhere. */
static PyObject *compared(PyObject *const *args, Py_ssize_t given, int opposite)
{
    Pass pass;
    Value *a = &pass.a, *b = &pass.b;
    if (!begin(&pass, args, given, 2) || may_be_nan(args[0]) || may_be_nan(args[1])) Py_RETURN_NONE;
    PyArrayObject *less = new_flags(&pass.shape), *not_less = new_flags(&pass.shape);
    if (!less || !not_less) {
        Py_XDECREF(less);
        Py_XDECREF(not_less);
        return NULL;
    }
    npy_bool *true_ = PyArray_DATA(less), *false_ = PyArray_DATA(not_less);
    for (npy_intp start = 0; start < pass.shape.size; start += BLOCK) {
        npy_intp count = block_at(&pass.shape, start);
        load_settled(a, start, count);
        load_settled(b, start, count);
        compare(count, a, b, true_ + start, false_ + start);
    }
    PyObject *rules = SLOT(args[0], bands.rules);
    return opposite ? new_truth(not_less, less, rules) : new_truth(less, not_less, rules);
}

static PyObject *less(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return compared(args, given, 0);
}

static PyObject *not_less(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return compared(args, given, 1);
}

#endif
