/* Parts of bands, and what a shader got as bands. */

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
    Columns columns = no_columns();
    Place place = place_of(&operand, 0);
    columns.shape.ndim = PyArray_NDIM(array);
    columns.rows = columns.shape.ndim == 2 ? PyArray_DIM(array, 0) : 1;
    for (int k = 0; k < width; k++) {
        columns.columns[k] = place;
        columns.columns[k].data += components[k] * place.along;
    }
    columns.width = width;
    return join_columns(&columns);
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

LOOP int64_t widened(npy_intp count, const float *from, double *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &from[i], sizeof bits);
        bits &= 0x7FFFFFFF;
        to[i] = from[i];
        /* From the smallest normal number to infinity. */
        rare |= (bits != 0) & (bits - 0x00800000 > 0x7F000000) ? ODD : 0;
    }
    return rare;
}

/* ordinary(values): float32 values as float64; None where one is a denormal or NaN. */
static PyObject *ordinary(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 1 || !PyArray_Check(args[0])) Py_RETURN_NONE;
    PyArrayObject *values = (PyArrayObject *)args[0];
    if (PyArray_TYPE(values) != NPY_FLOAT || !PyArray_ISBEHAVED_RO(values)) Py_RETURN_NONE;
    if (!(values = PyArray_GETCONTIGUOUS(values))) return NULL;
    PyObject *made = PyArray_SimpleNew(PyArray_NDIM(values), PyArray_DIMS(values), NPY_DOUBLE);
    if (made && widened(PyArray_SIZE(values), PyArray_DATA(values), PyArray_DATA((PyArrayObject *)made)))
        Py_SETREF(made, Py_NewRef(Py_None));
    Py_DECREF(values);
    return made;
}

#endif
