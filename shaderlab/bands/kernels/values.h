/* A band as a pass reads it, and the band that it makes. */

#ifndef SHADERLAB_VALUES_H
#define SHADERLAB_VALUES_H

typedef struct {
    Operand lo, hi, mag, slack, reach;
    int exact, plain, slackened, reaching;
    double count;
    /* Of the current block: bounds, bounds with the slack paid, the size of the terms, and by what
     * a flushed product among them may be multiplied. */
    const double *low, *high, *settled_low, *settled_high, *size, *reached;
    ALIGNED double blocks[4][BLOCK];
} Value;

typedef struct {
    PyArrayObject *lo, *hi, *mag, *slack, *reach;
    double *low, *high, *size, *step, *reached;
    int flush, exact;
    double count;
    /* Bits set where the NumPy code must do it, and where two bounds differ. */
    int64_t rare, differ;
} Result;

/* Reads a band's slots; false where the pass can't take it. */
static int read_value(Value *value, PyObject *band)
{
    if (!is_band(band)) return 0;
    PyObject *lo = SLOT(band, bands.lo), *hi = SLOT(band, bands.hi);
    PyObject *terms = SLOT(band, bands.terms);
    if (!terms || !is_operand(&value->lo, lo)) return 0;
    value->exact = lo == hi;
    if (!value->exact && !is_operand(&value->hi, hi)) return 0;
    value->plain = terms == Py_None;
    value->slackened = value->reaching = 0;
    value->count = 1.0;
    if (value->plain) return 1;
    if (!Py_IS_TYPE(terms, term_lists.type)) return 0;
    PyObject *slack = SLOT(terms, term_lists.slack), *reach = SLOT(terms, term_lists.reach);
    value->count = PyLong_AsDouble(SLOT(terms, term_lists.count));
    value->slackened = slack != Py_None;
    value->reaching = reach != Py_None;
    if (value->slackened && !is_operand(&value->slack, slack)) return 0;
    if (value->reaching && !is_operand(&value->reach, reach)) return 0;
    return is_operand(&value->mag, SLOT(terms, term_lists.mag));
}

/* Whether all of a band's arrays have one shape. */
static int of_one_shape(const Value *value)
{
    PyArrayObject *lo = value->lo.array;
    return (value->exact || PyArray_SAMESHAPE(lo, value->hi.array))
        && (value->plain || PyArray_SAMESHAPE(lo, value->mag.array))
        && (!value->slackened || PyArray_SAMESHAPE(lo, value->slack.array))
        && (!value->reaching || PyArray_SAMESHAPE(lo, value->reach.array));
}

static int broadcast_value(Shape *shape, const Value *value)
{
    return broadcast(shape, &value->lo) && (value->exact || broadcast(shape, &value->hi))
        && (value->plain || broadcast(shape, &value->mag))
        && (!value->slackened || broadcast(shape, &value->slack))
        && (!value->reaching || broadcast(shape, &value->reach));
}

static void prepare_value(Value *value, const Shape *shape)
{
    prepare(&value->lo, shape);
    if (!value->exact) prepare(&value->hi, shape);
    if (!value->plain) prepare(&value->mag, shape);
    if (value->slackened) prepare(&value->slack, shape);
    if (value->reaching) prepare(&value->reach, shape);
}

LOOP void sizes(npy_intp count, const double *lo, const double *hi, double *restrict size)
{
    for (npy_intp i = 0; i < count; i++)
        size[i] = smaller(larger(fabs(lo[i]), fabs(hi[i])), LARGEST);
}

LOOP void settle(
    npy_intp count, const double *lo, const double *hi, const double *slack, double *restrict low,
    double *restrict high)
{
    for (npy_intp i = 0; i < count; i++) {
        low[i] = lo[i] - slack[i];
        high[i] = hi[i] + slack[i];
    }
}

/* Makes a block of the bounds the current one. */
static void load_bounds(Value *value, npy_intp start, npy_intp count)
{
    value->low = values_at(&value->lo, start, count);
    value->high = value->exact ? value->low : values_at(&value->hi, start, count);
}

/* The same with the bounds of which the slack is paid. */
static void load_settled(Value *value, npy_intp start, npy_intp count)
{
    load_bounds(value, start, count);
    value->settled_low = value->low;
    value->settled_high = value->high;
    if (value->slackened) {
        value->settled_low = value->blocks[0];
        value->settled_high = value->blocks[1];
        const double *slack = values_at(&value->slack, start, count);
        settle(count, value->low, value->high, slack, value->blocks[0], value->blocks[1]);
    }
}

/* Whether each block holds the same bounds. */
static int is_repeated(const Value *value)
{
    return value->lo.kind == REPEATED && (value->exact || value->hi.kind == REPEATED);
}

/* Makes a block the current one. */
static void load(Value *value, npy_intp start, npy_intp count)
{
    load_settled(value, start, count);
    if (value->plain) {
        value->size = value->blocks[2];
        if (start && is_repeated(value)) return;
        sizes(count, value->low, value->high, value->blocks[2]);
    } else
        value->size = values_at(&value->mag, start, count);
}

LOOP void at_least_one(npy_intp count, const double *size, double *restrict to)
{
    for (npy_intp i = 0; i < count; i++) to[i] = larger(size[i], 1.0);
}

/* Where terms may be tiny: terms of which none is have a reach of their own size. */
static void load_reach(Value *value, npy_intp start, npy_intp count)
{
    value->reached = value->blocks[3];
    if (value->reaching) value->reached = values_at(&value->reach, start, count);
    else at_least_one(count, value->size, value->blocks[3]);
}

static PyArrayObject *new_array(const Shape *shape, double **data)
{
    PyObject *made = PyArray_SimpleNew(shape->ndim, (npy_intp *)shape->dims, NPY_DOUBLE);
    if (made) *data = PyArray_DATA((PyArrayObject *)made);
    return (PyArrayObject *)made;
}

static void drop(Result *result)
{
    Py_CLEAR(result->lo);
    Py_CLEAR(result->hi);
    Py_CLEAR(result->mag);
    Py_CLEAR(result->slack);
    Py_CLEAR(result->reach);
}

/* Makes room for a band of this shape; -1 with an exception where there is none. */
static int make_room(Result *result, const Shape *shape, int with_size, int with_slack)
{
    if ((result->lo = new_array(shape, &result->low))
        && (result->hi = new_array(shape, &result->high))
        && (!with_size || (result->mag = new_array(shape, &result->size)))
        && (!with_slack || (result->slack = new_array(shape, &result->step))))
        return 0;
    drop(result);
    return -1;
}

/* Whether there is a result; `lo` twice where all of it is exact. */
static int succeeded(Result *result)
{
    if (result->rare) {
        drop(result);
        return 0;
    }
    if (result->exact && !result->differ)
        Py_SETREF(result->hi, (PyArrayObject *)Py_NewRef((PyObject *)result->lo));
    return 1;
}

#endif
