/* Bands joined to vectors, all of their arrays in one way. */

#ifndef SHADERLAB_JOINS_H
#define SHADERLAB_JOINS_H

/* As many as a matrix has elements. */
#define MAX_COLUMNS 16

/* The columns of vectors of one or two axes that are joined along the last one. */
typedef struct {
    Shape shape;
    npy_intp rows, width;
    Place columns[MAX_COLUMNS];
} Columns;

/* Adds those of an array; false where a pass can't take it. */
static int add_columns(Columns *to, PyObject *part)
{
    Operand operand;
    if (!is_operand(&operand, part)) return 0;
    int ndim = PyArray_NDIM(operand.array);
    if (ndim < 1 || ndim > 2) return 0;
    npy_intp rows = ndim == 2 ? PyArray_DIM(operand.array, 0) : 1;
    npy_intp width = PyArray_DIM(operand.array, ndim - 1);
    if (to->rows != 1 && rows != 1 && rows != to->rows) return 0;
    if (to->width + width > MAX_COLUMNS) return 0;
    if (rows != 1) to->rows = rows;
    if (ndim == 2) to->shape.ndim = 2;
    Place place = place_of(&operand, 0);
    for (npy_intp j = 0; j < width; j++, place.data += place.along)
        to->columns[to->width++] = place;
    return 1;
}

static PyArrayObject *join_columns(Columns *from)
{
    ALIGNED double blocks[MAX_COLUMNS][ROWS];
    const double *at[MAX_COLUMNS];
    double *to;
    from->shape.dims[0] = from->rows;
    from->shape.dims[from->shape.ndim - 1] = from->width;
    PyArrayObject *made = new_array(&from->shape, &to);
    for (npy_intp start = 0; made && start < from->rows; start += ROWS) {
        npy_intp count = from->rows - start < ROWS ? from->rows - start : ROWS;
        for (npy_intp j = 0; j < from->width; j++)
            at[j] = picked(&from->columns[j], 0, 0, start, count,
                           from->width > 1 ? blocks[j] : to + start);
        if (at[0] == to + start) continue;
        put_together(count, from->width, at, to + start * from->width);
    }
    return made;
}

static Columns no_columns(void) { return (Columns){.shape = {.ndim = 1}, .rows = 1}; }

/* joined_last(arrays): vectors of one or two axes joined along the last one. */
static PyObject *joined_last(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 1 || !PyList_Check(args[0])) Py_RETURN_NONE;
    Columns columns = no_columns();
    for (Py_ssize_t k = 0; k < PyList_GET_SIZE(args[0]); k++)
        if (!add_columns(&columns, PyList_GET_ITEM(args[0], k))) Py_RETURN_NONE;
    return (PyObject *)join_columns(&columns);
}

/* By what flushed products of a band's terms may be multiplied, of terms of which none is tiny. */
static PyObject *reach_of(PyObject *band)
{
    Operand sizes;
    Shape shape = {0};
    double *to;
    PyObject *mag = PyObject_GetAttrString(band, "mag");
    if (!mag || !is_operand(&sizes, mag) || !broadcast(&shape, &sizes)) return mag;
    PyArrayObject *made = new_array(&shape, &to);
    if (made && shape.size) prepare(&sizes, &shape);
    for (npy_intp start = 0; made && start < shape.size; start += BLOCK) {
        npy_intp count = shape.size - start < BLOCK ? shape.size - start : BLOCK;
        at_least_one(count, values_at(&sizes, start, count), to + start);
    }
    Py_DECREF(mag);
    return (PyObject *)made;
}

/* What a slot of a band or of its terms holds: zeros or their own sizes where those have nothing. */
static PyObject *in_slot(PyObject *band, Py_ssize_t slot, int of_terms)
{
    PyObject *terms = SLOT(band, bands.terms);
    if (!of_terms) return Py_NewRef(SLOT(band, slot));
    if (slot == term_lists.mag) return PyObject_GetAttrString(band, "mag");
    if (terms != Py_None && SLOT(terms, slot) != Py_None) return Py_NewRef(SLOT(terms, slot));
    if (slot == term_lists.reach) return reach_of(band);
    PyArrayObject *lo = (PyArrayObject *)SLOT(band, bands.lo);
    return PyArray_ZEROS(PyArray_NDIM(lo), PyArray_DIMS(lo), NPY_DOUBLE, 0);
}

/* Joins one array of each band; false with an exception, or where NumPy must do it. */
static int join_into(PyArrayObject **to, PyObject *parts, Py_ssize_t slot, int of_terms)
{
    Py_ssize_t count = PyList_GET_SIZE(parts), k = 0;
    PyObject *arrays[MAX_COLUMNS];
    Columns columns = no_columns();
    int ready = 1;
    while (k < count && ready) {
        if (!(arrays[k] = in_slot(PyList_GET_ITEM(parts, k), slot, of_terms))) ready = 0;
        else ready = add_columns(&columns, arrays[k++]);
    }
    *to = ready ? join_columns(&columns) : NULL;
    while (k) Py_DECREF(arrays[--k]);
    return *to != NULL;
}

LOOP void copy_flags(
    npy_intp rows, npy_intp width, const npy_bool *from, npy_intp apart, npy_intp along,
    npy_bool *restrict to, npy_intp stride)
{
    for (npy_intp j = 0; j < width; j++)
        for (npy_intp i = 0; i < rows; i++) to[i * stride + j] = from[i * apart + j * along];
}

/* Joins one of the flags of each band, in arrays of this shape; NULL with an exception. */
static PyObject *join_flag(PyObject *parts, int flag, const Shape *shape)
{
    Py_ssize_t count = PyList_GET_SIZE(parts);
    npy_intp width = shape->dims[shape->ndim - 1], rows = shape->size / width;
    int set = 0;
    for (Py_ssize_t k = 0; k < count; k++) set |= flag_of(PyList_GET_ITEM(parts, k), flag) != NULL;
    if (!set) return Py_NewRef(PyTuple_GET_ITEM(nowhere, flag));
    PyObject *made = PyArray_ZEROS(shape->ndim, (npy_intp *)shape->dims, NPY_BOOL, 0);
    npy_bool *to = made ? PyArray_DATA((PyArrayObject *)made) : NULL;
    for (Py_ssize_t k = 0; made && k < count; k++) {
        PyObject *part = PyList_GET_ITEM(parts, k);
        PyArrayObject *lo = (PyArrayObject *)SLOT(part, bands.lo);
        PyArrayObject *from = flag_of(part, flag);
        npy_intp own = PyArray_DIM(lo, PyArray_NDIM(lo) - 1), apart = 0, along = 0;
        int last = from ? PyArray_NDIM(from) - 1 : 0;
        if (from && PyArray_DIM(from, last) != 1) along = PyArray_STRIDE(from, last);
        if (last > 0 && PyArray_DIM(from, 0) != 1) apart = PyArray_STRIDE(from, 0);
        if (from) copy_flags(rows, own, PyArray_DATA(from), apart, along, to, width);
        to += own;
    }
    return made;
}

/* Joins the flags of bands. */
static PyObject *join_flags(PyObject *parts, PyArrayObject *joined)
{
    Shape shape = {.ndim = PyArray_NDIM(joined), .size = PyArray_SIZE(joined)};
    memcpy(shape.dims, PyArray_DIMS(joined), shape.ndim * sizeof *shape.dims);
    PyObject *flags = PyTuple_New(3);
    for (int k = 0; flags && k < 3; k++) {
        PyObject *made = join_flag(parts, k, &shape);
        if (made) PyTuple_SET_ITEM(flags, k, made);
        else Py_CLEAR(flags);
    }
    return flags;
}

/* joined(bands, axis): vectors of one or two axes along the last axis. */
static PyObject *joined(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 2 || !PyList_Check(args[0]) || !PyList_GET_SIZE(args[0])) Py_RETURN_NONE;
    if (!PyLong_Check(args[1]) || PyLong_AsLong(args[1]) != -1) Py_RETURN_NONE;
    if (PyList_GET_SIZE(args[0]) > MAX_COLUMNS) Py_RETURN_NONE;
    int exact = 1, plain = 1, slackened = 0, reaching = 0, flags_set = 0;
    double terms = 1.0;
    Result parts = {0};
    Value value;
    for (Py_ssize_t k = 0; k < PyList_GET_SIZE(args[0]); k++) {
        PyObject *band = PyList_GET_ITEM(args[0], k);
        if (!read_value(&value, band) || !of_one_shape(&value)) Py_RETURN_NONE;
        if (!PyArray_SIZE(value.lo.array)) Py_RETURN_NONE;
        flags_set |= !flagless(SLOT(band, bands.flags));
        exact &= value.exact;
        plain &= value.plain;
        slackened |= value.slackened;
        reaching |= value.reaching;
        terms = larger(terms, value.count);
    }
    int made = join_into(&parts.lo, args[0], bands.lo, 0);
    if (made && !exact) made = join_into(&parts.hi, args[0], bands.hi, 0);
    if (made && !plain) made = join_into(&parts.mag, args[0], term_lists.mag, 1);
    if (made && slackened) made = join_into(&parts.slack, args[0], term_lists.slack, 1);
    if (made && reaching) made = join_into(&parts.reach, args[0], term_lists.reach, 1);
    PyObject *flags = NULL, *first = PyList_GET_ITEM(args[0], 0);
    if (made && flags_set) flags = join_flags(args[0], parts.lo);
    else if (made) flags = Py_NewRef(nowhere);
    if (!flags) {
        drop(&parts);
        return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
    }
    if (exact) parts.hi = (PyArrayObject *)Py_NewRef((PyObject *)parts.lo);
    PyObject *sums = NULL;
    if (!plain) sums = new_terms(parts.mag, parts.slack, (long)terms, parts.reach);
    return new_band(parts.lo, parts.hi, SLOT(first, bands.rules), flags, sums);
}

#endif
