/* Choosing between values: nothing is rounded. */

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

#endif
