/* Sums and differences. */

#ifndef SHADERLAB_SUMS_H
#define SHADERLAB_SUMS_H

/* Terms whose sizes add up to the result's have one sign, and keep it in any order. */
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

VERSION int64_t added_plain(
    npy_intp count, const Value *a, const Value *b, int tiny, double *restrict lo,
    const double *negated_hi, double *restrict size, double *restrict slack,
    double *restrict reach)
{
    const double *a_size = a->size, *b_size = b->size, *a_reach = a->reached, *b_reach = b->reached;
    double unit = SMALLEST_NORMAL * (a->count + b->count);
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double mag = a_size[i] + b_size[i], flushed = 0.0;
        if (tiny) {
            reach[i] = a_reach[i] + b_reach[i];
            flushed = unit * reach[i];
        }
        size[i] = mag;
        slack[i] = (a_size[i] > 0.0) & (b_size[i] > 0.0) ? step_of(mag, flushed, tiny) : 0.0;
        lo[i] += 0.0;
        rare |= rare_of(unbounded(lo[i], -negated_hi[i]), tiny ? 0.0 : mag);
    }
    return rare;
}

VERSION int64_t added_terms(
    npy_intp count, const Value *a, const Value *b, int tiny, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict reach)
{
    const double *a_low = a->low, *a_high = a->high, *b_low = b->low, *b_high = b->high;
    const double *a_lo = a->settled_low, *a_hi = a->settled_high;
    const double *b_lo = b->settled_low, *b_hi = b->settled_high;
    const double *a_size = a->size, *b_size = b->size, *a_reach = a->reached, *b_reach = b->reached;
    double more_b = (a->count - 1.0) * RELATIVE_STEP, more_a = (b->count - 1.0) * RELATIVE_STEP;
    double unit = SMALLEST_NORMAL * (a->count + b->count);
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double low = lo[i] + 0.0, high = -negated_hi[i], mag = a_size[i] + b_size[i];
        double flushed = 0.0;
        if (tiny) {
            reach[i] = a_reach[i] + b_reach[i];
            flushed = unit * reach[i];
        }
        double step = (a_size[i] > 0.0) & (b_size[i] > 0.0) ? step_of(mag, flushed, tiny) : 0.0;
        step = step + more_b * b_size[i] + more_a * a_size[i];
        double out_low = low - step, out_high = high + step, enough = mag * UNCANCELLED;
        int positive = (a_low[i] >= 0.0) & (b_low[i] >= 0.0)
            & ((a_lo[i] + b_lo[i] >= step) | (high >= enough));
        int negative = (a_high[i] <= 0.0) & (b_high[i] <= 0.0)
            & ((a_hi[i] + b_hi[i] <= -step) | (-low >= enough));
        lo[i] = (out_low < 0.0) & positive ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & negative ? 0.0 : -out_high;
        size[i] = mag;
        rare |= rare_of(unbounded(low, high), tiny ? 0.0 : mag);
    }
    return rare;
}

LOOP int64_t add_plain(
    npy_intp count, const Value *a, const Value *b, double *restrict lo, const double *negated_hi,
    double *restrict size, double *restrict slack)
{
    return added_plain(count, a, b, 0, lo, negated_hi, size, slack, NULL);
}

LOOP int64_t add_plain_tiny(
    npy_intp count, const Value *a, const Value *b, double *restrict lo, const double *negated_hi,
    double *restrict size, double *restrict slack, double *restrict reach)
{
    return added_plain(count, a, b, 1, lo, negated_hi, size, slack, reach);
}

LOOP int64_t add_terms(
    npy_intp count, const Value *a, const Value *b, double *restrict lo,
    double *restrict negated_hi, double *restrict size)
{
    return added_terms(count, a, b, 0, lo, negated_hi, size, NULL);
}

LOOP int64_t add_terms_tiny(
    npy_intp count, const Value *a, const Value *b, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict reach)
{
    return added_terms(count, a, b, 1, lo, negated_hi, size, reach);
}

LOOP int64_t check_bounds(npy_intp count, double *restrict lo, const double *negated_hi)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        lo[i] += 0.0;
        rare |= unbounded(lo[i], -negated_hi[i]) ? ODD : 0;
    }
    return rare;
}

static int64_t sum_block(Pass *pass, npy_intp start)
{
    npy_intp count = pass->count;
    Value *a = &pass->a, *b = &pass->b;
    Result *result = &pass->result;
    double *lo = pass->lo, *negated_hi = pass->negated_hi, *size = result->size + start;
    ALIGNED double opposite[4][BLOCK];
    if (pass->minus) negate(b, count, opposite);
    sum(count, a->settled_low, a->settled_high, b->settled_low, b->settled_high, lo, negated_hi);
    if (!pass->rearrange) return check_bounds(count, lo, negated_hi);
    double *reach = pass->tiny ? result->reached + start : NULL;
    if (a->plain && b->plain) {
        double *slack = result->step + start;
        return reach ? add_plain_tiny(count, a, b, lo, negated_hi, size, slack, reach)
                     : add_plain(count, a, b, lo, negated_hi, size, slack);
    }
    return reach ? add_terms_tiny(count, a, b, lo, negated_hi, size, reach)
                 : add_terms(count, a, b, lo, negated_hi, size);
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
    pass.minus = minus;
    if (run(&pass, 2, sum_block, a->reaching || b->reaching)) return NULL;
    return finished(&pass);
}

static PyObject *add(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_of(args, given, 0);
}

static PyObject *subtract(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_of(args, given, 1);
}

#endif
