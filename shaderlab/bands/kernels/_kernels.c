/* The arithmetic of bands in one pass over its arrays: the twin of arithmetic.py, which has the
 * reasons and does whatever a pass finds rare (infinities, denormal products, divisors near zero).
 *
 * Each function takes bands and two of their rules, `flush` and `rearrange`, and returns
 * (lo, hi, mag, slack, count), or None where the NumPy code must do it. Both give the same numbers;
 * the sign of a zero bound means nothing and may differ. */

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#include <numpy/arrayobject.h>

#include <fenv.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "operands.h"
#include "rounding.h"
#include "values.h"

#define DIVISION_ULPS 2.5
#define LARGEST_DIVISOR 0x1p126
#define UNCANCELLED (1.0 - 0x1p-20)

LOOP void negated(npy_intp count, const double *from, double *restrict to)
{
    for (npy_intp i = 0; i < count; i++) to[i] = -from[i];
}

/* Negates the current block of the band that is subtracted. */
static void negate(Value *value, npy_intp count, double to[4][BLOCK])
{
    negated(count, value->high, to[0]);
    negated(count, value->low, to[1]);
    if (value->slackened) {
        negated(count, value->settled_high, to[2]);
        negated(count, value->settled_low, to[3]);
    }
    value->low = to[0];
    value->high = to[1];
    value->settled_low = to[value->slackened ? 2 : 0];
    value->settled_high = to[value->slackened ? 3 : 1];
}

LOOP int64_t add_plain(
    npy_intp count, const double *a_size, const double *b_size, double *restrict lo, const double *negated_hi,
    double *restrict size, double *restrict slack)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double mag = a_size[i] + b_size[i];
        size[i] = mag;
        slack[i] = (a_size[i] > 0.0) & (b_size[i] > 0.0) ? RELATIVE_STEP * mag : 0.0;
        lo[i] += 0.0;
        rare |= unbounded(lo[i], -negated_hi[i]) | ((mag > 0.0) & (mag < TINY)) ? -1 : 0;
    }
    return rare;
}

LOOP int64_t add_terms(
    npy_intp count, const Value *a, const Value *b, double *restrict lo, double *restrict negated_hi, double *restrict size)
{
    const double *a_low = a->low, *a_high = a->high, *b_low = b->low, *b_high = b->high;
    const double *a_lo = a->settled_low, *a_hi = a->settled_high;
    const double *b_lo = b->settled_low, *b_hi = b->settled_high;
    const double *a_size = a->size, *b_size = b->size;
    double more_b = (a->count - 1.0) * RELATIVE_STEP, more_a = (b->count - 1.0) * RELATIVE_STEP;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double low = lo[i] + 0.0, high = -negated_hi[i], mag = a_size[i] + b_size[i];
        double step = (a_size[i] > 0.0) & (b_size[i] > 0.0) ? RELATIVE_STEP * mag : 0.0;
        step = step + more_b * b_size[i] + more_a * a_size[i];
        double out_low = low - step, out_high = high + step, enough = mag * UNCANCELLED;
        int positive = (a_low[i] >= 0.0) & (b_low[i] >= 0.0)
            & ((a_lo[i] + b_lo[i] >= step) | (high >= enough));
        int negative = (a_high[i] <= 0.0) & (b_high[i] <= 0.0)
            & ((a_hi[i] + b_hi[i] <= -step) | (-low >= enough));
        lo[i] = (out_low < 0.0) & positive ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & negative ? 0.0 : -out_high;
        size[i] = mag;
        rare |= unbounded(low, high) | ((mag > 0.0) & (mag < TINY)) ? -1 : 0;
    }
    return rare;
}

LOOP int64_t check_bounds(npy_intp count, double *restrict lo, const double *negated_hi)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        lo[i] += 0.0;
        rare |= unbounded(lo[i], -negated_hi[i]) ? -1 : 0;
    }
    return rare;
}

/* One pass: one or two bands, blocks of them, and the band that is made. */
typedef struct {
    Value a, b;
    Shape shape;
    Result result;
    int rearrange;
    npy_intp count;
    double lo[BLOCK], negated_hi[BLOCK];
} Pass;

/* Reads the arguments; false where the NumPy code must do it. */
static int begin(Pass *pass, PyObject *const *args, Py_ssize_t given, int bands)
{
    memset(&pass->shape, 0, sizeof pass->shape);
    memset(&pass->result, 0, sizeof pass->result);
    if (given != bands + 2 || !read_value(&pass->a, args[0])) return 0;
    if (bands == 2 && !read_value(&pass->b, args[1])) return 0;
    pass->result.flush = args[bands] == Py_True;
    pass->rearrange = args[bands + 1] == Py_True;
    pass->result.count = 1.0;
    if (!broadcast_value(&pass->shape, &pass->a)) return 0;
    if (bands == 2 && !broadcast_value(&pass->shape, &pass->b)) return 0;
    if (!pass->shape.size) return 0;
    prepare_value(&pass->a, &pass->shape);
    if (bands == 2) prepare_value(&pass->b, &pass->shape);
    return 1;
}

/* Makes the block that begins at `start` the current one; false behind the last, or where something
 * was rare. */
static int at_block(Pass *pass, npy_intp start, int bands)
{
    if (start >= pass->shape.size || pass->result.rare) return 0;
    pass->count = pass->shape.size - start < BLOCK ? pass->shape.size - start : BLOCK;
    load(&pass->a, start, pass->count);
    if (bands == 2) load(&pass->b, start, pass->count);
    return 1;
}

static void end_block(Pass *pass, npy_intp start)
{
    Result *result = &pass->result;
    result->differ |= narrow(pass->count, result->flush, pass->lo, pass->negated_hi,
                             result->low + start, result->high + start);
}

static PyObject *sum_of(PyObject *const *args, Py_ssize_t given, int minus)
{
    Pass pass;
    if (!begin(&pass, args, given, 2)) Py_RETURN_NONE;
    Value *a = &pass.a, *b = &pass.b;
    Result *result = &pass.result;
    int plain = a->plain && b->plain;
    if (make_room(result, &pass.shape, pass.rearrange, pass.rearrange && plain)) return NULL;
    result->exact = a->exact && b->exact && plain;
    result->count = a->count + b->count;
    double opposite[4][BLOCK];
    for (npy_intp start = 0; at_block(&pass, start, 2); start += BLOCK) {
        npy_intp count = pass.count;
        if (minus) negate(b, count, opposite);
        sum(count, a->settled_low, a->settled_high, b->settled_low, b->settled_high, pass.lo,
            pass.negated_hi);
        if (!pass.rearrange)
            result->rare = check_bounds(count, pass.lo, pass.negated_hi);
        else if (plain)
            result->rare = add_plain(count, a->size, b->size, pass.lo, pass.negated_hi,
                                     result->size + start, result->step + start);
        else
            result->rare = add_terms(
                count, a, b, pass.lo, pass.negated_hi, result->size + start);
        end_block(&pass, start);
    }
    return finished(result);
}

static PyObject *add(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_of(args, given, 0);
}

static PyObject *subtract(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_of(args, given, 1);
}

/* `steps` times the rounding among the terms is added; 0 for plain values, which have none. */
LOOP int64_t multiply_block(
    npy_intp count, const Value *a, const Value *b, double steps, double *restrict lo, double *restrict negated_hi,
    double *restrict size)
{
    const double *a_lo = a->settled_low, *a_hi = a->settled_high, *a_size = a->size;
    const double *b_lo = b->settled_low, *b_hi = b->settled_high, *b_size = b->size;
    double uncancelled = steps > 1.0 ? UNCANCELLED : 0.0, relative = RELATIVE_STEP;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double first = a_lo[i] * b_lo[i], second = a_lo[i] * b_hi[i];
        double third = a_hi[i] * b_lo[i], fourth = a_hi[i] * b_hi[i];
        double low = smaller(smaller(first, second), smaller(third, fourth));
        double high = larger(larger(first, second), larger(third, fourth));
        double mag = a_size[i] * b_size[i], step = steps * (relative * mag);
        double out_low = low - step, out_high = high + step, enough = mag * uncancelled;
        int positive = (low >= 0.0) & (high >= enough);
        int negative = (high <= 0.0) & (-low >= enough);
        lo[i] = (out_low < 0.0) & positive ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & negative ? 0.0 : -out_high;
        size[i] = mag;
        rare |= unbounded(low, high) | ((mag > 0.0) & (mag < TINY)) | !(mag < INFINITY) ? -1 : 0;
    }
    return rare;
}

/* Whether a band is a few factors ±2^k, which round nothing. */
static int is_scale(const Value *value)
{
    Shape own = {0};
    Operand factors = {.array = value->lo.array};
    if (!value->exact || !value->plain || PyArray_SIZE(factors.array) > 16) return 0;
    broadcast(&own, &factors);
    prepare(&factors, &own);
    const double *factor = values_at(&factors, 0, own.size);
    for (npy_intp i = 0; i < own.size; i++)
        if (bits_of(factor[i]) & 0x000FFFFFFFFFFFFF) return 0;
    return 1;
}

LOOP int64_t scale_block(
    npy_intp count, const Value *a, const double *factor, const double *slack, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict scaled_slack)
{
    const double *a_lo = a->low, *a_hi = a->high, *a_size = a->size;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double first = a_lo[i] * factor[i], second = a_hi[i] * factor[i];
        double low = smaller(first, second), high = larger(first, second);
        size[i] = a_size[i] * fabs(factor[i]);
        lo[i] = low;
        negated_hi[i] = -high;
        rare |= unbounded(low, high) ? -1 : 0;
    }
    if (slack)
        for (npy_intp i = 0; i < count; i++) {
            double scaled = slack[i] * fabs(factor[i]);
            scaled_slack[i] = scaled > 0.0 ? larger(scaled, SMALLEST_NORMAL) : 0.0;
        }
    return rare;
}

LOOP int64_t any_tiny(npy_intp count, const double *size)
{
    int64_t found = 0;
    for (npy_intp i = 0; i < count; i++) found |= (size[i] > 0.0) & (size[i] < TINY) ? -1 : 0;
    return found;
}

/* a · ±2^k: a pending slack stays pending. */
static PyObject *scale(Pass *pass, Value *a, Value *b)
{
    Result *result = &pass->result;
    if (make_room(result, &pass->shape, !a->plain, a->slackened)) return NULL;
    result->exact = a->exact;
    result->count = a->count;
    double size[BLOCK];
    for (npy_intp start = 0; at_block(pass, start, 2); start += BLOCK) {
        const double *slack = a->slackened ? values_at(&a->slack, start, pass->count) : NULL;
        double *to = a->plain ? size : result->size + start;
        double *step = slack ? result->step + start : NULL;
        result->rare = scale_block(
            pass->count, a, b->low, slack, pass->lo, pass->negated_hi, to, step);
        if (a->plain && pass->rearrange) result->rare |= any_tiny(pass->count, size);
        end_block(pass, start);
    }
    return finished(result);
}

LOOP int64_t square_block(
    npy_intp count, const Value *a, double steps, double *restrict lo, double *restrict negated_hi, double *restrict size)
{
    const double *a_lo = a->low, *a_hi = a->high;
    double relative = RELATIVE_STEP;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double first = a_lo[i] * a_lo[i], second = a_hi[i] * a_hi[i];
        double least = smaller(first, second), high = larger(first, second);
        double low = (a_lo[i] < 0.0) & (a_hi[i] > 0.0) ? 0.0 : least, mag = smaller(high, LARGEST);
        double step = steps * (relative * mag);
        lo[i] = larger(low - step, 0.0);
        negated_hi[i] = -(high + step);
        size[i] = mag;
        rare |= unbounded(low, high) | ((mag > 0.0) & (mag < TINY)) ? -1 : 0;
    }
    return rare;
}

static PyObject *square_of(Pass *pass)
{
    Value *a = &pass->a;
    Result *result = &pass->result;
    if (make_room(result, &pass->shape, 1, 0)) return NULL;
    result->exact = a->exact;
    double steps = pass->rearrange && !a->plain && !a->exact ? 1.0 : 0.0;
    for (npy_intp start = 0; at_block(pass, start, 1); start += BLOCK) {
        result->rare = square_block(
            pass->count, a, steps, pass->lo, pass->negated_hi, result->size + start);
        end_block(pass, start);
    }
    if (!pass->rearrange) Py_CLEAR(result->mag);
    return finished(result);
}

static PyObject *square(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    if (!begin(&pass, args, given, 1)) Py_RETURN_NONE;
    return square_of(&pass);
}

static PyObject *multiply(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    if (given == 4 && args[0] == args[1]) return square(self, args + 1, 3);
    if (!begin(&pass, args, given, 2)) Py_RETURN_NONE;
    Value *a = &pass.a, *b = &pass.b;
    Result *result = &pass.result;
    if (is_scale(a)) return scale(&pass, b, a);
    if (is_scale(b)) return scale(&pass, a, b);
    if (make_room(result, &pass.shape, 1, 0)) return NULL;
    int plain = a->plain && b->plain;
    result->exact = a->exact && b->exact && plain;
    result->count = a->count * b->count;
    double steps = plain ? 0.0 : a->plain || b->plain ? 1.0 : larger(3.0, result->count - 1.0);
    for (npy_intp start = 0; at_block(&pass, start, 2); start += BLOCK) {
        result->rare = multiply_block(
            pass.count, a, b, steps, pass.lo, pass.negated_hi, result->size + start);
        end_block(&pass, start);
    }
    if (!pass.rearrange) Py_CLEAR(result->mag);
    return finished(result);
}

LOOP int64_t divide_block(
    npy_intp count, const Value *a, const Value *b, int terms, double *restrict lo, double *restrict negated_hi,
    double *restrict size)
{
    const double *a_lo = a->settled_low, *a_hi = a->settled_high, *a_size = a->size;
    const double *b_lo = b->low, *b_hi = b->high;
    double steps = terms ? DIVISION_ULPS : 0.0, relative = RELATIVE_STEP;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double below = b_lo[i], above = b_hi[i];
        double nearer = smaller(fabs(below), fabs(above)), further = larger(fabs(below), fabs(above));
        int outside = (nearer < SMALLEST_NORMAL) | (further > LARGEST_DIVISOR)
            | ((below <= 0.0) & (above >= 0.0));
        /* A quotient grows with the dividend where the divisor is positive. */
        double first = a_lo[i], second = a_hi[i];
        double less = below > 0.0 ? first : second, more = below > 0.0 ? second : first;
        double under = less >= 0.0 ? above : below, over = more >= 0.0 ? below : above;
        double low = less / under, high = more / over;
        rare |= unbounded(low, high) | outside ? -1 : 0;
        widen(&low, &high, DIVISION_ULPS, DIVISION_ULPS);
        double mag = a_size[i] / nearer, step = steps * (relative * mag);
        double out_low = low - step, out_high = high + step;
        lo[i] = (out_low < 0.0) & (low >= 0.0) ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & (high <= 0.0) ? 0.0 : -out_high;
        size[i] = mag;
        rare |= terms & (((mag > 0.0) & (mag < TINY)) | !(mag < INFINITY)) ? -1 : 0;
    }
    return rare;
}

static PyObject *divide(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    if (!begin(&pass, args, given, 2)) Py_RETURN_NONE;
    Result *result = &pass.result;
    int terms = !pass.a.plain;
    if (make_room(result, &pass.shape, 1, 0)) return NULL;
    result->count = pass.a.count;
    for (npy_intp start = 0; at_block(&pass, start, 2); start += BLOCK) {
        result->rare = divide_block(pass.count, &pass.a, &pass.b, terms, pass.lo, pass.negated_hi,
                                    result->size + start);
        end_block(&pass, start);
    }
    if (!terms) Py_CLEAR(result->mag);
    return finished(result);
}

#define METHOD(name) {#name, (PyCFunction)(void (*)(void))name, METH_FASTCALL, NULL}

static PyMethodDef methods[] = {
    METHOD(add), METHOD(subtract), METHOD(multiply), METHOD(square), METHOD(divide), {0}};

static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "_kernels", NULL, -1, methods};

/* Whether the compiler left the rounding direction alone. */
static int rounds_outward(void)
{
    double a[4] = {1.0, -1.0, 1.0, -1.0}, b[4] = {0x1p-80, 0x1p-80, -0x1p-80, -0x1p-80};
    double lo[4], hi[4], low[4], high[4];
    sum(4, a, a, b, b, lo, hi);
    narrow(4, 1, lo, hi, low, high);
    double next = 0x1p-23, before = 0x1p-24;
    return low[0] == 1.0 && high[0] == 1.0 + next && low[1] == -1.0 && high[1] == before - 1.0
        && low[2] == 1.0 - before && high[2] == 1.0 && low[3] == -1.0 - next && high[3] == -1.0
        && hi[1] == lo[2] && hi[0] == lo[3];
}

PyMODINIT_FUNC PyInit__kernels(void)
{
    import_array();
    if (!rounds_outward()) {
        PyErr_SetString(PyExc_ImportError, "this compiler ignores the rounding direction");
        return NULL;
    }
    name_lo = PyUnicode_InternFromString("lo");
    name_hi = PyUnicode_InternFromString("hi");
    name_terms = PyUnicode_InternFromString("terms");
    name_mag = PyUnicode_InternFromString("mag");
    name_slack = PyUnicode_InternFromString("slack");
    name_count = PyUnicode_InternFromString("count");
    name_reach = PyUnicode_InternFromString("reach");
    return PyModule_Create(&module);
}
