/* Operands of a pass over arrays: any shape that broadcasts, presented as blocks of consecutive
 * values of the result. What has the result's shape is read where it lies; what repeats with a
 * short period is written out once; the rest is gathered block by block. So each pass is one loop
 * over consecutive values. */

#ifndef SHADERLAB_OPERANDS_H
#define SHADERLAB_OPERANDS_H

/* A dozen blocks fit into a first-level cache; a multiple of 2, 3, 4, 8, 12, 16. */
#define BLOCK 384
/* A register of 64 bytes never lies across two lines of the cache. */
#define ALIGNED _Alignas(64)
#define MAX_DIMS 6

typedef struct {
    int ndim;
    npy_intp dims[MAX_DIMS];
    npy_intp size;
} Shape;

typedef struct {
    PyArrayObject *array;
    const double *data;
    enum { WHOLE, REPEATED, GATHERED } kind;
    /* Of the gathered: dimensions that can't be joined to one, strides in values. */
    int ndim;
    npy_intp dims[MAX_DIMS], strides[MAX_DIMS];
    ALIGNED double block[BLOCK];
} Operand;

/* Whether this is an array that the loops can read; the operand borrows it. */
static int is_operand(Operand *operand, PyObject *object)
{
    if (!object || !PyArray_Check(object)) return 0;
    PyArrayObject *array = (PyArrayObject *)object;
    operand->array = array;
    return PyArray_TYPE(array) == NPY_DOUBLE && PyArray_ISBEHAVED_RO(array)
        && PyArray_NDIM(array) <= MAX_DIMS;
}

/* Broadcasts `shape` with the operand's; false where they don't fit. */
static int broadcast(Shape *shape, const Operand *operand)
{
    int ndim = PyArray_NDIM(operand->array);
    const npy_intp *dims = PyArray_DIMS(operand->array);
    while (shape->ndim < ndim) {
        memmove(shape->dims + 1, shape->dims, shape->ndim * sizeof *shape->dims);
        shape->dims[0] = 1;
        shape->ndim++;
    }
    npy_intp *last = shape->dims + shape->ndim - ndim;
    for (int i = 0; i < ndim; i++) {
        if (last[i] == 1) last[i] = dims[i];
        else if (dims[i] != 1 && dims[i] != last[i]) return 0;
    }
    shape->size = 1;
    for (int i = 0; i < shape->ndim; i++) shape->size *= shape->dims[i];
    return 1;
}

/* One in so many values; the compiler knows a few strides better than any. */
LOOP void every(npy_intp count, const double *from, npy_intp stride, double *restrict to)
{
    switch (stride) {
    case 2: for (npy_intp i = 0; i < count; i++) to[i] = from[2 * i]; break;
    case 3: for (npy_intp i = 0; i < count; i++) to[i] = from[3 * i]; break;
    case 4: for (npy_intp i = 0; i < count; i++) to[i] = from[4 * i]; break;
    default: for (npy_intp i = 0; i < count; i++) to[i] = from[i * stride];
    }
}

/* Rows of few values each, `apart` from each other, one after the other. */
LOOP void line_up(
    npy_intp rows, npy_intp length, const double *from, npy_intp apart, npy_intp stride,
    double *restrict to)
{
    if (!stride && length == 3)
        for (npy_intp i = 0; i < rows; i++)
            to[3 * i] = to[3 * i + 1] = to[3 * i + 2] = from[i * apart];
    else if (!stride && length == 4)
        for (npy_intp i = 0; i < rows; i++)
            to[4 * i] = to[4 * i + 1] = to[4 * i + 2] = to[4 * i + 3] = from[i * apart];
    else if (stride == 1 && length == 3)
        for (npy_intp i = 0; i < rows; i++)
            for (npy_intp j = 0; j < 3; j++) to[3 * i + j] = from[i * apart + j];
    else
        for (npy_intp j = 0; j < length; j++)
            for (npy_intp i = 0; i < rows; i++) to[i * length + j] = from[i * apart + j * stride];
}

static void gather(const Operand *operand, npy_intp start, npy_intp count, double *to)
{
    int last = operand->ndim - 1;
    npy_intp length = operand->dims[last], stride = operand->strides[last];
    if (last == 1 && start % length == 0 && count % length == 0 && length <= 16) {
        npy_intp rows = count / length, apart = operand->strides[0];
        line_up(rows, length, operand->data + start / length * apart, apart, stride, to);
        return;
    }
    npy_intp at[MAX_DIMS], rest = start;
    const double *row = operand->data;
    for (int i = last; i >= 0; i--) {
        at[i] = rest % operand->dims[i];
        rest /= operand->dims[i];
        if (i < last) row += at[i] * operand->strides[i];
    }
    npy_intp j = at[last];
    while (count > 0) {
        npy_intp run = length - j < count ? length - j : count;
        every(run, row + j * stride, stride, to);
        to += run;
        count -= run;
        j = 0;
        for (int i = last - 1; i >= 0; i--) {
            row += operand->strides[i];
            if (++at[i] < operand->dims[i]) break;
            row -= at[i] * operand->strides[i];
            at[i] = 0;
        }
    }
}

/* Prepares an operand for blocks of a result of this shape, which is not empty. */
static void prepare(Operand *operand, const Shape *shape)
{
    PyArrayObject *array = operand->array;
    int missing = shape->ndim - PyArray_NDIM(array), used = 0;
    operand->data = PyArray_DATA(array);
    if (PyArray_SIZE(array) == shape->size && PyArray_IS_C_CONTIGUOUS(array)) {
        operand->kind = WHOLE;
        return;
    }
    for (int i = 0; i < shape->ndim; i++) {
        npy_intp length = shape->dims[i], stride = 0;
        if (length == 1) continue;
        if (i >= missing && PyArray_DIM(array, i - missing) != 1)
            stride = PyArray_STRIDE(array, i - missing) / (npy_intp)sizeof(double);
        if (used && operand->strides[used - 1] == stride * length) {
            operand->dims[used - 1] *= length;
            operand->strides[used - 1] = stride;
        } else {
            operand->dims[used] = length;
            operand->strides[used++] = stride;
        }
    }
    if (!used) {
        operand->dims[0] = 1;
        operand->strides[used++] = 0;
    }
    operand->ndim = used;
    npy_intp period = operand->strides[0] ? shape->size : shape->size / operand->dims[0];
    operand->kind = GATHERED;
    if (BLOCK % period == 0) {
        operand->kind = REPEATED;
        npy_intp count = BLOCK < shape->size ? BLOCK : shape->size;
        gather(operand, 0, count, operand->block);
    }
}

/* The operand's values for `count` values of the result, from `start` on: a multiple of BLOCK. */
static const double *values_at(Operand *operand, npy_intp start, npy_intp count)
{
    if (operand->kind == WHOLE) return operand->data + start;
    if (operand->kind == GATHERED) gather(operand, start, count, operand->block);
    return operand->block;
}

#endif
