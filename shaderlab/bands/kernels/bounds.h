/* Bounds that are no band yet, rounded outward. */

#ifndef SHADERLAB_BOUNDS_H
#define SHADERLAB_BOUNDS_H

/* outward(lo, hi, flush): (lo, hi), one array twice where one was given and nothing was rounded. */
static PyObject *outward(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Operand lo, hi;
    Shape shape = {0};
    if (given != 3 || !is_operand(&lo, args[0]) || !is_operand(&hi, args[1])) Py_RETURN_NONE;
    if (!PyArray_SAMESHAPE(lo.array, hi.array)) Py_RETURN_NONE;
    if (!broadcast(&shape, &lo) || !shape.size) Py_RETURN_NONE;
    Result result = {.flush = args[2] == Py_True, .exact = args[0] == args[1]};
    if (make_room(&result, &shape, 0, 0)) return NULL;
    prepare(&lo, &shape);
    prepare(&hi, &shape);
    for (npy_intp start = 0; start < shape.size; start += BLOCK) {
        ALIGNED double negated_hi[BLOCK];
        npy_intp count = shape.size - start < BLOCK ? shape.size - start : BLOCK;
        negated(count, values_at(&hi, start, count), negated_hi);
        result.differ |= narrow(count, result.flush, values_at(&lo, start, count), negated_hi,
                                result.low + start, result.high + start);
    }
    if (!succeeded(&result)) Py_RETURN_NONE;
    return Py_BuildValue("NN", result.lo, result.hi);
}

#endif
