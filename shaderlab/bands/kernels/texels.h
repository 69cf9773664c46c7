/* Texels looked up by column, row and layer; the twin of sampling/reading.py. */

#ifndef SHADERLAB_TEXELS_H
#define SHADERLAB_TEXELS_H

typedef enum { REPEAT, MIRRORED_REPEAT, CLAMP_TO_EDGE, OTHERWISE } Wrap;

static Wrap wrap_of(PyObject *mode)
{
    if (!PyUnicode_Check(mode)) return OTHERWISE;
    if (PyUnicode_CompareWithASCIIString(mode, "repeat") == 0) return REPEAT;
    if (PyUnicode_CompareWithASCIIString(mode, "mirrored_repeat") == 0) return MIRRORED_REPEAT;
    if (PyUnicode_CompareWithASCIIString(mode, "clamp_to_edge") == 0) return CLAMP_TO_EDGE;
    return OTHERWISE;
}

static inline int64_t modulo(int64_t index, int64_t size)
{
    int64_t rest = index % size;
    return rest < 0 ? rest + size : rest;
}

static inline int64_t folded(int64_t index, int64_t size)
{
    return index < size ? index : 2 * size - 1 - index;
}

/* The texels that whole numbers stand for; nonzero where one is no number of a sensible size. */
LOOP int64_t wrap(
    npy_intp count, const double *at, int64_t size, Wrap mode, int64_t *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        int sensible = fabs(at[i]) < 0x1p52;
        rare |= sensible ? 0 : ODD;
        to[i] = (int64_t)(sensible ? at[i] : 0.0);
    }
    int64_t period = mode == MIRRORED_REPEAT ? 2 * size : size;
    if (mode == CLAMP_TO_EDGE)
        for (npy_intp i = 0; i < count; i++) {
            int64_t least = to[i] > 0 ? to[i] : 0;
            to[i] = least < size ? least : size - 1;
        }
    else if (!(period & (period - 1)))
        for (npy_intp i = 0; i < count; i++) to[i] &= period - 1;
    else
        for (npy_intp i = 0; i < count; i++) to[i] = modulo(to[i], period);
    if (mode == MIRRORED_REPEAT)
        for (npy_intp i = 0; i < count; i++) to[i] = folded(to[i], size);
    return rare;
}

/* Four components of each texel: absent ones are 0, absent alpha 1. */
#define COPY_TEXELS(type, read)                                                     \
    for (npy_intp i = 0; i < count; i++) {                                          \
        const type *texel = (const type *)values + place[i] * channels;             \
        for (npy_intp k = 0; k < 4; k++)                                            \
            to[4 * i + k] = k < channels ? (read) : k == 3 ? 1.0 : 0.0;             \
    }

static void copy_texels(
    npy_intp count, const void *values, int type, npy_intp channels, const double *table,
    const int64_t *place, double *restrict to)
{
    if (type == NPY_UBYTE) COPY_TEXELS(uint8_t, table[texel[k]])
    else if (type == NPY_FLOAT) COPY_TEXELS(float, (double)texel[k])
    else COPY_TEXELS(double, texel[k])
}

/* Numbers neither 0 nor 1 moved by a relative error. */
LOOP void err(npy_intp count, double error, double *restrict low, double *restrict high)
{
    for (npy_intp i = 0; i < count; i++) {
        double number = low[i];
        double give = (number == 0.0) | (number == 1.0) ? 0.0 : error * number;
        low[i] = number - give;
        high[i] = number + give;
    }
}

/* An array of one axis of this length, or none. */
static const void *row_of(PyObject *object, int type, npy_intp *length)
{
    if (!PyArray_Check(object)) return NULL;
    PyArrayObject *array = (PyArrayObject *)object;
    if (PyArray_TYPE(array) != type || PyArray_NDIM(array) != 1) return NULL;
    if (!PyArray_ISCARRAY_RO(array)) return NULL;
    if (*length < 0) *length = PyArray_DIM(array, 0);
    return PyArray_DIM(array, 0) == *length ? PyArray_DATA(array) : NULL;
}

/* texels_at(values, x, y, layer, wrap of x, wrap of y, lowest, highest, error):
 * (low, high). */
static PyObject *texels_at(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Result result = {0};
    npy_intp count = -1, codes = 256;
    if (given != 9 || !PyArray_Check(args[0])) Py_RETURN_NONE;
    PyArrayObject *values = (PyArrayObject *)args[0];
    int type = PyArray_TYPE(values), coded = type == NPY_UBYTE;
    if (PyArray_NDIM(values) != 4 || !PyArray_ISCARRAY_RO(values)) Py_RETURN_NONE;
    if (!coded && type != NPY_FLOAT && type != NPY_DOUBLE) Py_RETURN_NONE;
    const double *x = row_of(args[1], NPY_DOUBLE, &count), *y = row_of(args[2], NPY_DOUBLE, &count);
    const int64_t *layer = row_of(args[3], NPY_INT64, &count);
    Wrap across = wrap_of(args[4]), up = wrap_of(args[5]);
    if (!x || !y || !layer || across == OTHERWISE || up == OTHERWISE) Py_RETURN_NONE;
    const double *tables[] = {NULL, NULL};
    for (int k = 0; k < 2 && coded; k++)
        if (!(tables[k] = row_of(args[6 + k], NPY_DOUBLE, &codes))) Py_RETURN_NONE;
    const npy_intp *dims = PyArray_DIMS(values);
    npy_intp layers = dims[0], height = dims[1], width = dims[2], channels = dims[3];
    if (!count || channels > 4 || !width || !height) Py_RETURN_NONE;
    Shape shape = {.ndim = 2, .dims = {count, 4}, .size = 4 * count};
    double error = PyFloat_Check(args[8]) ? PyFloat_AS_DOUBLE(args[8]) : 0.0;
    result.exact = tables[0] == tables[1] && error == 0.0;
    if (make_room(&result, &shape, 0, 0)) return NULL;
    for (npy_intp start = 0; start < count && !result.rare; start += BLOCK) {
        int64_t column[BLOCK], row[BLOCK];
        npy_intp some = count - start < BLOCK ? count - start : BLOCK;
        result.rare = wrap(some, x + start, width, across, column);
        result.rare |= wrap(some, y + start, height, up, row);
        for (npy_intp i = 0; i < some; i++) {
            int64_t number = layer[start + i];
            if (number < 0 || number >= layers) result.rare = ODD;
            column[i] += (number * height + row[i]) * width;
        }
        if (result.rare) break;
        const void *data = PyArray_DATA(values);
        copy_texels(some, data, type, channels, tables[0], column, result.low + 4 * start);
        if (error != 0.0) err(4 * some, error, result.low + 4 * start, result.high + 4 * start);
        if (!coded || result.exact) continue;
        copy_texels(some, data, type, channels, tables[1], column, result.high + 4 * start);
    }
    return two_arrays(&result);
}

#endif
