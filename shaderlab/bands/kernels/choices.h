/* Choosing between values and joining them: nothing is rounded. */

#ifndef SHADERLAB_CHOICES_H
#define SHADERLAB_CHOICES_H

LOOP void take_greater(
    npy_intp count, const double *side, const double *a, const double *b, double *restrict to)
{
    for (npy_intp i = 0; i < count; i++)
        to[i] = side[i] > 0.0 ? a[i] : side[i] < 0.0 ? b[i] : larger(a[i], b[i]);
}

LOOP void take_lesser(
    npy_intp count, const double *side, const double *a, const double *b, double *restrict to)
{
    for (npy_intp i = 0; i < count; i++)
        to[i] = side[i] > 0.0 ? a[i] : side[i] < 0.0 ? b[i] : smaller(a[i], b[i]);
}

/* taken(side, a, b, greater): a where the side is 1, b where it is -1, elsewhere the greater or
 * the lesser of both. */
static PyObject *taken(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Operand operands[3];
    Shape shape;
    double *to;
    if (given != 4 || !read_operands(operands, args, 3, &shape)) Py_RETURN_NONE;
    PyArrayObject *made = new_array(&shape, &to);
    if (!made) return NULL;
    int greater = args[3] == Py_True;
    for (npy_intp start = 0; start < shape.size; start += BLOCK) {
        npy_intp count = shape.size - start < BLOCK ? shape.size - start : BLOCK;
        const double *side = values_at(&operands[0], start, count);
        const double *a = values_at(&operands[1], start, count);
        const double *b = values_at(&operands[2], start, count);
        if (greater) take_greater(count, side, a, b, to + start);
        else take_lesser(count, side, a, b, to + start);
    }
    return (PyObject *)made;
}

/* The components of a part, one after the other, into rows of `width` values. */
static void put_part(PyArrayObject *part, npy_intp rows, npy_intp width, double *to)
{
    int last = PyArray_NDIM(part) - 1;
    npy_intp along = PyArray_STRIDE(part, last) / (npy_intp)sizeof(double), down = 0;
    if (last && PyArray_DIM(part, 0) != 1)
        down = PyArray_STRIDE(part, 0) / (npy_intp)sizeof(double);
    for (npy_intp first = 0; first < rows; first += BLOCK) {
        npy_intp count = rows - first < BLOCK ? rows - first : BLOCK;
        for (npy_intp j = 0; j < PyArray_DIM(part, last); j++) {
            const double *from = (const double *)PyArray_DATA(part) + first * down + j * along;
            double *at = to + first * width + j;
            for (npy_intp i = 0; i < count; i++) at[i * width] = from[i * down];
        }
    }
}

/* joined_last(arrays): vectors of one or two axes joined along the last one. */
static PyObject *joined_last(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 1 || !PyList_Check(args[0])) Py_RETURN_NONE;
    Shape shape = {.ndim = 1};
    npy_intp rows = 1, width = 0;
    for (Py_ssize_t k = 0; k < PyList_GET_SIZE(args[0]); k++) {
        PyObject *object = PyList_GET_ITEM(args[0], k);
        if (!PyArray_Check(object)) Py_RETURN_NONE;
        PyArrayObject *part = (PyArrayObject *)object;
        int ndim = PyArray_NDIM(part);
        if (PyArray_TYPE(part) != NPY_DOUBLE || !PyArray_ISBEHAVED_RO(part)) Py_RETURN_NONE;
        if (ndim < 1 || ndim > 2) Py_RETURN_NONE;
        npy_intp own = ndim == 2 ? PyArray_DIM(part, 0) : 1;
        if (rows != 1 && own != 1 && own != rows) Py_RETURN_NONE;
        if (own != 1) rows = own;
        if (ndim == 2) shape.ndim = 2;
        width += PyArray_DIM(part, ndim - 1);
    }
    double *to;
    shape.dims[0] = rows;
    shape.dims[shape.ndim - 1] = width;
    PyArrayObject *made = new_array(&shape, &to);
    if (!made) return NULL;
    for (Py_ssize_t k = 0; k < PyList_GET_SIZE(args[0]); k++) {
        PyArrayObject *part = (PyArrayObject *)PyList_GET_ITEM(args[0], k);
        put_part(part, rows, width, to);
        to += PyArray_DIM(part, PyArray_NDIM(part) - 1);
    }
    return (PyObject *)made;
}

#endif
