/* float32 values held against float32 bounds; the twins of bands/allowed.py, judging/distance.py and
 * judging/informative.py. */

#ifndef SHADERLAB_JUDGED_H
#define SHADERLAB_JUDGED_H

#define JUDGED 4096

/* The data of `count` float32 arrays of one shape; false where they are something else. */
static int floats_alike(PyObject *const *objects, int count, const float **data)
{
    PyArrayObject *first = (PyArrayObject *)objects[0];
    for (int k = 0; k < count; k++) {
        PyArrayObject *array = (PyArrayObject *)objects[k];
        if (!PyArray_Check(objects[k]) || PyArray_TYPE(array) != NPY_FLOAT) return 0;
        if (!PyArray_ISCARRAY_RO(array) || !PyArray_SAMESHAPE(array, first)) return 0;
        data[k] = PyArray_DATA(array);
    }
    return 1;
}

LOOP void between(
    npy_intp count, const float *low, const float *high, const float *value, npy_bool *restrict to)
{
    for (npy_intp i = 0; i < count; i++) to[i] = (value[i] >= low[i]) & (value[i] <= high[i]);
}

/* contains(lo, hi, nan, measured), where no NaN is legal. */
static PyObject *contained(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    const float *data[3];
    if (given != 4 || args[2] != PyArrayScalar_False) Py_RETURN_NONE;
    PyObject *const arrays[] = {args[0], args[1], args[3]};
    if (!floats_alike(arrays, 3, data)) Py_RETURN_NONE;
    PyArrayObject *values = (PyArrayObject *)args[3];
    PyObject *made = PyArray_SimpleNew(PyArray_NDIM(values), PyArray_DIMS(values), NPY_BOOL);
    if (!made) return NULL;
    npy_bool *to = PyArray_DATA((PyArrayObject *)made);
    between(PyArray_SIZE(values), data[0], data[1], data[2], to);
    return made;
}

/* Distances from the middle, in half widths, and the bits of the largest, which are in the order of
 * the numbers; negative where a band is wider than a float32 can hold. */
LOOP int32_t distances(
    npy_intp count, const float *low, const float *high, const float *value,
    float *restrict distance)
{
    int32_t largest = 0, wide = 0;
    for (npy_intp i = 0; i < count; i++) {
        float whole = high[i] - low[i];
        float found = fabsf((value[i] - low[i]) - (high[i] - value[i])) / whole;
        wide |= whole < INFINITY ? 0 : -1;
        found = found > 0.0f ? found : 0.0f;
        distance[i] = found < 1.0f ? found : 1.0f;
    }
    for (npy_intp i = 0; i < count; i++) {
        int32_t bits;
        memcpy(&bits, &distance[i], sizeof bits);
        largest = bits > largest ? bits : largest;
    }
    return wide ? -1 : largest;
}

/* furthest(low, high, measured, inside, unit), where all are inside of bands with two ends. */
static PyObject *furthest_of_all(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    const float *data[3];
    if (given != 5 || !floats_alike(args, 3, data) || !PyArray_Check(args[3])) Py_RETURN_NONE;
    PyArrayObject *values = (PyArrayObject *)args[2], *inside = (PyArrayObject *)args[3];
    if (PyArray_TYPE(inside) != NPY_BOOL || !PyArray_ISCARRAY_RO(inside)) Py_RETURN_NONE;
    npy_intp count = PyArray_SIZE(values), found = 0;
    if (PyArray_SIZE(inside) != count || memchr(PyArray_DATA(inside), 0, count)) Py_RETURN_NONE;
    int32_t largest = -1;
    for (npy_intp start = 0; start < count; start += JUDGED) {
        float distance[JUDGED], greatest;
        npy_intp some = count - start < JUDGED ? count - start : JUDGED, at = 0;
        int32_t here = distances(
            some, data[0] + start, data[1] + start, data[2] + start, distance);
        if (here < 0) Py_RETURN_NONE;
        if (here <= largest) continue;
        largest = here;
        memcpy(&greatest, &here, sizeof greatest);
        while (distance[at] != greatest) at++;
        found = start + at;
    }
    return PyLong_FromSsize_t(found);
}

LOOP npy_intp leaving_out(
    npy_intp count, const float *low, const float *high, const float *least, const float *greatest,
    const int32_t *varies)
{
    int32_t found = 0;
    for (npy_intp i = 0; i < count; i++) {
        float width = high[i] - low[i];
        int32_t leaves_out = (low[i] > least[i] ? 1 : 0) | (high[i] < greatest[i] ? 1 : 0);
        int32_t narrow = width < greatest[i] ? 1 : 0, bounded = width < INFINITY ? 1 : 0;
        found += ((leaves_out & varies[i]) | (narrow & ~varies[i])) & bounded;
    }
    return found;
}

/* informative(low, high, least, greatest, varies), of bounds (count, components). */
static PyObject *informative(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    const float *data[2], *ends[2];
    if (given != 5 || !floats_alike(args, 2, data) || !floats_alike(args + 2, 2, ends))
        Py_RETURN_NONE;
    PyArrayObject *low = (PyArrayObject *)args[0], *end = (PyArrayObject *)args[2];
    PyArrayObject *flags = (PyArrayObject *)args[4];
    if (PyArray_NDIM(low) != 2 || PyArray_NDIM(end) != 1) Py_RETURN_NONE;
    if (!PyArray_Check(args[4]) || PyArray_TYPE(flags) != NPY_BOOL) Py_RETURN_NONE;
    npy_intp components = PyArray_DIM(low, 1), count = PyArray_SIZE(low);
    if (!PyArray_ISCARRAY_RO(flags) || PyArray_NDIM(flags) != 1) Py_RETURN_NONE;
    if (PyArray_DIM(flags, 0) != components || PyArray_DIM(end, 0) != components) Py_RETURN_NONE;
    if (components < 1 || components > 4) Py_RETURN_NONE;
    float least[JUDGED], greatest[JUDGED];
    int32_t varies[JUDGED];
    const npy_bool *flag = PyArray_DATA(flags);
    npy_intp block = JUDGED / components * components, found = 0;
    for (npy_intp i = 0; i < block && i < count; i++) {
        least[i] = ends[0][i % components];
        greatest[i] = ends[1][i % components];
        varies[i] = flag[i % components];
    }
    for (npy_intp start = 0; start < count; start += block) {
        npy_intp some = count - start < block ? count - start : block;
        found += leaving_out(
            some, data[0] + start, data[1] + start, least, greatest, varies);
    }
    return PyLong_FromSsize_t(found);
}

#endif
