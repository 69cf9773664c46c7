/* Bands taken apart and put together, all of their arrays in one way. */

#ifndef SHADERLAB_SHAPES_H
#define SHADERLAB_SHAPES_H

/* The components that a list names: (..., [0, 2]); -1 where the index is something else. */
static int listed(PyObject *index, npy_intp length, npy_intp *components, int most)
{
    if (!PyTuple_Check(index) || PyTuple_GET_SIZE(index) != 2) return -1;
    PyObject *list = PyTuple_GET_ITEM(index, 1);
    if (PyTuple_GET_ITEM(index, 0) != Py_Ellipsis || !PyList_Check(list)) return -1;
    if (PyList_GET_SIZE(list) < 1 || PyList_GET_SIZE(list) > most) return -1;
    for (int k = 0; k < PyList_GET_SIZE(list); k++) {
        PyObject *item = PyList_GET_ITEM(list, k);
        if (!PyLong_CheckExact(item)) return -1;
        components[k] = PyLong_AsSsize_t(item);
        if (components[k] < 0 || components[k] >= length) {
            PyErr_Clear();
            return -1;
        }
    }
    return (int)PyList_GET_SIZE(list);
}

/* Some components of vectors of one or two axes. */
static PyArrayObject *components_of(PyArrayObject *array, const npy_intp *components, int width)
{
    Operand operand = {.array = array};
    int ndim = PyArray_NDIM(array);
    Place place = place_of(&operand, 0);
    npy_intp rows = ndim == 2 ? PyArray_DIM(array, 0) : 1;
    Shape shape = {.ndim = ndim, .dims = {rows, width}};
    if (ndim == 1) shape.dims[0] = width;
    double *to;
    ALIGNED double block[BLOCK];
    PyArrayObject *made = new_array(&shape, &to);
    for (npy_intp start = 0; made && start < rows; start += BLOCK) {
        npy_intp count = rows - start < BLOCK ? rows - start : BLOCK;
        for (int k = 0; k < width; k++) {
            const double *from = picked(&place, 0, components[k], start, count, block);
            spread(count, from, width, to + start * width + k);
        }
    }
    return made;
}

/* The part of an array at an index, as an array. */
static PyArrayObject *part_of(
    PyArrayObject *array, PyObject *index, const npy_intp *components, int width)
{
    if (width > 0) return components_of(array, components, width);
    PyObject *part = PyObject_GetItem((PyObject *)array, index);
    if (part && !PyArray_Check(part)) Py_SETREF(part, PyArray_FromAny(part, NULL, 0, 0, 0, NULL));
    return (PyArrayObject *)part;
}

/* band[index], of a band whose arrays have one shape and whose flags are set nowhere. */
static PyObject *indexed(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Value value;
    Result parts = {0};
    npy_intp components[MAX_TERMS];
    if (given != 2 || !read_value(&value, args[0]) || !of_one_shape(&value)) Py_RETURN_NONE;
    if (!flagless(SLOT(args[0], bands.flags))) Py_RETURN_NONE;
    PyArrayObject *lo = value.lo.array;
    int ndim = PyArray_NDIM(lo), width = -1;
    if (ndim == 1 || ndim == 2)
        width = listed(args[1], PyArray_DIM(lo, ndim - 1), components, MAX_TERMS);
    struct {
        int wanted;
        Operand *from;
        PyArrayObject **to;
    } arrays[] = {{1, &value.lo, &parts.lo}, {!value.exact, &value.hi, &parts.hi},
                  {!value.plain, &value.mag, &parts.mag},
                  {value.slackened, &value.slack, &parts.slack},
                  {value.reaching, &value.reach, &parts.reach}};
    for (int k = 0; k < 5; k++) {
        if (!arrays[k].wanted) continue;
        *arrays[k].to = part_of(arrays[k].from->array, args[1], components, width);
        if (*arrays[k].to) continue;
        drop(&parts);
        return NULL;
    }
    if (value.exact) parts.hi = (PyArrayObject *)Py_NewRef((PyObject *)parts.lo);
    PyObject *terms = NULL;
    if (!value.plain) terms = new_terms(parts.mag, parts.slack, (long)value.count, parts.reach);
    return new_band(parts.lo, parts.hi, SLOT(args[0], bands.rules),
                    Py_NewRef(SLOT(args[0], bands.flags)), terms);
}

/* One array of each part, joined along the last axis: from a slot of the bands, or of their terms,
 * and zeros where those have none. */
static PyObject *join_slots(PyObject *parts, Py_ssize_t slot, int of_terms)
{
    Py_ssize_t count = PyList_GET_SIZE(parts);
    PyObject *arrays = PyList_New(count), *made = NULL;
    for (Py_ssize_t k = 0; arrays && k < count; k++) {
        PyObject *part = PyList_GET_ITEM(parts, k), *array = NULL;
        PyObject *terms = SLOT(part, bands.terms);
        if (!of_terms) array = Py_NewRef(SLOT(part, slot));
        else if (slot == term_lists.mag) array = PyObject_GetAttrString(part, "mag");
        else if (terms != Py_None && SLOT(terms, slot) != Py_None) array = Py_NewRef(SLOT(terms, slot));
        else {
            PyArrayObject *lo = (PyArrayObject *)SLOT(part, bands.lo);
            array = PyArray_ZEROS(PyArray_NDIM(lo), PyArray_DIMS(lo), NPY_DOUBLE, 0);
        }
        if (array) PyList_SET_ITEM(arrays, k, array);
        else Py_CLEAR(arrays);
    }
    if (!arrays) return NULL;
    made = joined_last(NULL, &arrays, 1);
    Py_DECREF(arrays);
    return made;
}

/* Joins the arrays of a slot; false with an exception, or where NumPy must do it. */
static int join_into(PyArrayObject **to, PyObject *parts, Py_ssize_t slot, int of_terms)
{
    PyObject *made = join_slots(parts, slot, of_terms);
    if (made == Py_None) Py_CLEAR(made);
    *to = (PyArrayObject *)made;
    return made != NULL;
}

/* joined(bands, axis): vectors along the last axis, whose flags are set nowhere and of whose terms
 * none is tiny. */
static PyObject *joined(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 2 || !PyList_Check(args[0]) || !PyList_GET_SIZE(args[0])) Py_RETURN_NONE;
    if (!PyLong_Check(args[1]) || PyLong_AsLong(args[1]) != -1) Py_RETURN_NONE;
    int exact = 1, plain = 1, slackened = 0;
    double terms = 1.0;
    Result parts = {0};
    Value value;
    for (Py_ssize_t k = 0; k < PyList_GET_SIZE(args[0]); k++) {
        PyObject *band = PyList_GET_ITEM(args[0], k);
        if (!read_value(&value, band) || !of_one_shape(&value) || value.reaching) Py_RETURN_NONE;
        if (!flagless(SLOT(band, bands.flags))) Py_RETURN_NONE;
        exact &= value.exact;
        plain &= value.plain;
        slackened |= value.slackened;
        terms = larger(terms, value.count);
    }
    int made = join_into(&parts.lo, args[0], bands.lo, 0);
    if (made && !exact) made = join_into(&parts.hi, args[0], bands.hi, 0);
    if (made && !plain) made = join_into(&parts.mag, args[0], term_lists.mag, 1);
    if (made && slackened) made = join_into(&parts.slack, args[0], term_lists.slack, 1);
    if (!made) {
        drop(&parts);
        return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
    }
    if (exact) parts.hi = (PyArrayObject *)Py_NewRef((PyObject *)parts.lo);
    PyObject *first = PyList_GET_ITEM(args[0], 0);
    PyObject *sums = plain ? NULL : new_terms(parts.mag, parts.slack, (long)terms, NULL);
    return new_band(parts.lo, parts.hi, SLOT(first, bands.rules),
                    Py_NewRef(SLOT(first, bands.flags)), sums);
}

LOOP int64_t widened(npy_intp count, const float *from, double *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double size = fabs((double)from[i]);
        to[i] = from[i];
        rare |= !(size >= SMALLEST_NORMAL) & !(size == 0.0) ? ODD : 0;
    }
    return rare;
}

/* ordinary(values): float32 values as float64; None where one is a denormal or NaN. */
static PyObject *ordinary(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 1 || !PyArray_Check(args[0])) Py_RETURN_NONE;
    PyArrayObject *values = (PyArrayObject *)args[0];
    if (PyArray_TYPE(values) != NPY_FLOAT || !PyArray_ISCARRAY_RO(values)) Py_RETURN_NONE;
    double *to;
    PyObject *made = PyArray_SimpleNew(PyArray_NDIM(values), PyArray_DIMS(values), NPY_DOUBLE);
    if (!made) return NULL;
    to = PyArray_DATA((PyArrayObject *)made);
    if (!widened(PyArray_SIZE(values), PyArray_DATA(values), to)) return made;
    Py_DECREF(made);
    Py_RETURN_NONE;
}

#endif
