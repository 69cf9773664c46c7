/* Products and squares. */

#ifndef SHADERLAB_PRODUCTS_H
#define SHADERLAB_PRODUCTS_H

/* `steps` times the rounding among the terms is added; 0 for plain values, which have none. */
VERSION int64_t multiplied(
    npy_intp count, const Value *a, const Value *b, double steps, int exact, int tiny,
    double *restrict lo, double *restrict negated_hi, double *restrict size,
    double *restrict reach)
{
    const double *a_lo = a->settled_low, *a_hi = exact ? a_lo : a->settled_high, *a_size = a->size;
    const double *b_lo = b->settled_low, *b_hi = b->settled_high, *b_size = b->size;
    const double *a_reach = a->reached, *b_reach = b->reached;
    double uncancelled = steps > 1.0 ? UNCANCELLED : 0.0;
    double unit = SMALLEST_NORMAL * (a->count * b->count);
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double first = a_lo[i] * b_lo[i], second = a_lo[i] * b_hi[i];
        double third = a_hi[i] * b_lo[i], fourth = a_hi[i] * b_hi[i];
        double low = smaller(smaller(first, second), smaller(third, fourth));
        double high = larger(larger(first, second), larger(third, fourth));
        double mag = a_size[i] * b_size[i], flushed = 0.0;
        if (tiny) {
            reach[i] = larger(a_reach[i] * b_reach[i], 1.0);
            flushed = unit * reach[i];
        }
        double step = steps * step_of(mag, flushed, tiny);
        double out_low = low - step, out_high = high + step, enough = mag * uncancelled;
        int safe = !tiny || (RELATIVE_STEP * mag >= flushed) | (mag == 0.0);
        int positive = (low >= 0.0) & safe & (high >= enough);
        int negative = (high <= 0.0) & safe & (-low >= enough);
        lo[i] = (out_low < 0.0) & positive ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & negative ? 0.0 : -out_high;
        size[i] = mag;
        /* Infinity times 0 is NaN, which minima and maxima may lose, but no sum does. */
        int odd = !(fabs(first + second + (third + fourth) + mag) < INFINITY);
        rare |= rare_of(odd, tiny ? 0.0 : mag);
    }
    return rare;
}

LOOP int64_t multiply_bands(
    npy_intp count, const Value *a, const Value *b, double steps, double *restrict lo,
    double *restrict negated_hi, double *restrict size)
{
    return multiplied(count, a, b, steps, 0, 0, lo, negated_hi, size, NULL);
}

LOOP int64_t multiply_exact(
    npy_intp count, const Value *a, const Value *b, double steps, double *restrict lo,
    double *restrict negated_hi, double *restrict size)
{
    return multiplied(count, a, b, steps, 1, 0, lo, negated_hi, size, NULL);
}

static int64_t multiply_block(
    npy_intp count, const Value *a, const Value *b, double steps, double *lo, double *negated_hi,
    double *size)
{
    if (a->settled_low == a->settled_high)
        return multiply_exact(count, a, b, steps, lo, negated_hi, size);
    if (b->settled_low == b->settled_high)
        return multiply_exact(count, b, a, steps, lo, negated_hi, size);
    return multiply_bands(count, a, b, steps, lo, negated_hi, size);
}

LOOP int64_t multiply_tiny(
    npy_intp count, const Value *a, const Value *b, double steps, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict reach)
{
    return multiplied(count, a, b, steps, 0, 1, lo, negated_hi, size, reach);
}

static int64_t product_block(Pass *pass, npy_intp start)
{
    Result *result = &pass->result;
    double *lo = pass->lo, *negated_hi = pass->negated_hi, *size = result->size + start;
    if (pass->tiny)
        return multiply_tiny(pass->count, &pass->a, &pass->b, pass->steps, lo, negated_hi, size,
                             result->reached + start);
    return multiply_block(pass->count, &pass->a, &pass->b, pass->steps, lo, negated_hi, size);
}

/* Whether a band is a few factors ±2^k, which round nothing: NumPy multiplies by those. */
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

VERSION int64_t squared(
    npy_intp count, const Value *a, double steps, int tiny, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict reach)
{
    const double *a_lo = a->low, *a_hi = a->high, *a_reach = a->reached;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double first = a_lo[i] * a_lo[i], second = a_hi[i] * a_hi[i];
        double one_sided = (a_lo[i] < 0.0) & (a_hi[i] > 0.0) ? 0.0 : 1.0;
        double low = one_sided * smaller(first, second), high = larger(first, second);
        double mag = smaller(high, LARGEST), flushed = 0.0;
        if (tiny) {
            reach[i] = larger(a_reach[i] * a_reach[i], 1.0);
            flushed = SMALLEST_NORMAL * reach[i];
        }
        double step = steps * step_of(mag, flushed, tiny);
        lo[i] = larger(low - step, 0.0);
        negated_hi[i] = -(high + step);
        size[i] = mag;
        rare |= rare_of(high == INFINITY, tiny ? 0.0 : mag);
    }
    return rare;
}

LOOP int64_t square_block(
    npy_intp count, const Value *a, double steps, double *restrict lo, double *restrict negated_hi,
    double *restrict size)
{
    return squared(count, a, steps, 0, lo, negated_hi, size, NULL);
}

LOOP int64_t square_tiny(
    npy_intp count, const Value *a, double steps, double *restrict lo, double *restrict negated_hi,
    double *restrict size, double *restrict reach)
{
    return squared(count, a, steps, 1, lo, negated_hi, size, reach);
}

static int64_t squares_block(Pass *pass, npy_intp start)
{
    Result *result = &pass->result;
    double *lo = pass->lo, *negated_hi = pass->negated_hi, *size = result->size + start;
    if (pass->tiny)
        return square_tiny(pass->count, &pass->a, pass->steps, lo, negated_hi, size,
                           result->reached + start);
    return square_block(pass->count, &pass->a, pass->steps, lo, negated_hi, size);
}

static PyObject *square_of(Pass *pass)
{
    Value *a = &pass->a;
    Result *result = &pass->result;
    if (make_room(result, &pass->shape, 1, 0)) return NULL;
    result->exact = a->exact;
    pass->steps = pass->rearrange && !a->plain && !a->exact ? 1.0 : 0.0;
    if (run(pass, 1, squares_block, a->reaching)) return NULL;
    if (!pass->rearrange) drop_terms(result);
    return finished(pass);
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
    if (given == 2 && args[0] == args[1]) return square(self, args, 1);
    if (!begin(&pass, args, given, 2)) Py_RETURN_NONE;
    Value *a = &pass.a, *b = &pass.b;
    Result *result = &pass.result;
    if (is_scale(a) || is_scale(b)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 1, 0)) return NULL;
    int plain = a->plain && b->plain;
    result->exact = a->exact && b->exact && plain;
    result->count = a->count * b->count;
    pass.steps = plain ? 0.0 : a->plain || b->plain ? 1.0 : larger(3.0, result->count - 1.0);
    if (run(&pass, 2, product_block, a->reaching || b->reaching)) return NULL;
    if (!pass.rearrange) drop_terms(result);
    return finished(&pass);
}

#endif
