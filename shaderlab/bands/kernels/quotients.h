/* Quotients and roots. */

#ifndef SHADERLAB_QUOTIENTS_H
#define SHADERLAB_QUOTIENTS_H

#define DIVISION_ULPS 2.5
#define LARGEST_DIVISOR 0x1p126
#define INVERSESQRT_ULPS 2.0

/* A quotient's bounds; nonzero where they or the divisor are none that the loops know. */
VERSION int quotient_of(
    double a_lo, double a_hi, double below, double above, double nearer, double *low, double *high)
{
    double further = larger(fabs(below), fabs(above));
    int outside = (nearer < SMALLEST_NORMAL) | (further > LARGEST_DIVISOR)
        | ((below <= 0.0) & (above >= 0.0));
    /* A quotient grows with the dividend where the divisor is positive. */
    double less = below > 0.0 ? a_lo : a_hi, more = below > 0.0 ? a_hi : a_lo;
    double under = less >= 0.0 ? above : below, over = more >= 0.0 ? below : above;
    *low = less / under;
    *high = more / over;
    int odd = unbounded(*low, *high) | outside;
    widen(low, high, DIVISION_ULPS, DIVISION_ULPS);
    return odd;
}

VERSION int64_t divided(
    npy_intp count, const Value *a, const Value *b, int plain, int tiny, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict reach)
{
    const double *a_lo = a->settled_low, *a_hi = a->settled_high, *a_size = a->size;
    const double *b_lo = b->low, *b_hi = b->high;
    const double *a_reach = a->reached;
    double unit = SMALLEST_NORMAL * a->count;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double nearer = smaller(fabs(b_lo[i]), fabs(b_hi[i])), low, high;
        int odd = quotient_of(a_lo[i], a_hi[i], b_lo[i], b_hi[i], nearer, &low, &high);
        if (plain) {
            lo[i] = low;
            negated_hi[i] = -high;
            rare |= odd ? ODD : 0;
            continue;
        }
        double mag = a_size[i] / nearer, flushed = 0.0;
        if (tiny) {
            reach[i] = a_reach[i] * larger(1.0 / nearer, 1.0);
            flushed = unit * reach[i];
        }
        double step = DIVISION_ULPS * step_of(mag, flushed, tiny);
        double out_low = low - step, out_high = high + step;
        int safe = !tiny || (RELATIVE_STEP * mag >= flushed) | (mag == 0.0);
        lo[i] = (out_low < 0.0) & (low >= 0.0) & safe ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & (high <= 0.0) & safe ? 0.0 : -out_high;
        size[i] = mag;
        rare |= rare_of(odd | !(mag < INFINITY), tiny ? 0.0 : mag);
    }
    return rare;
}

LOOP int64_t divide_plain(
    npy_intp count, const Value *a, const Value *b, double *restrict lo,
    double *restrict negated_hi)
{
    return divided(count, a, b, 1, 0, lo, negated_hi, NULL, NULL);
}

LOOP int64_t divide_terms(
    npy_intp count, const Value *a, const Value *b, double *restrict lo,
    double *restrict negated_hi, double *restrict size)
{
    return divided(count, a, b, 0, 0, lo, negated_hi, size, NULL);
}

LOOP int64_t divide_tiny(
    npy_intp count, const Value *a, const Value *b, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict reach)
{
    return divided(count, a, b, 0, 1, lo, negated_hi, size, reach);
}

static int64_t quotient_block(Pass *pass, npy_intp start)
{
    Result *result = &pass->result;
    double *lo = pass->lo, *negated_hi = pass->negated_hi;
    if (pass->a.plain) return divide_plain(pass->count, &pass->a, &pass->b, lo, negated_hi);
    double *size = result->size + start;
    if (pass->tiny)
        return divide_tiny(pass->count, &pass->a, &pass->b, lo, negated_hi, size,
                           result->reached + start);
    return divide_terms(pass->count, &pass->a, &pass->b, lo, negated_hi, size);
}

static PyObject *divide(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    if (!begin(&pass, args, given, 2)) Py_RETURN_NONE;
    Result *result = &pass.result;
    if (make_room(result, &pass.shape, !pass.a.plain, 0)) return NULL;
    result->count = pass.a.count;
    if (run(&pass, 2, quotient_block, pass.a.reaching)) return NULL;
    return finished(&pass);
}

/* 1/√x of what is not negative: the rest is left to NumPy. */
LOOP void reciprocal_roots(npy_intp count, const double *x, double *restrict to)
{
    for (npy_intp i = 0; i < count; i++) to[i] = 1.0 / sqrt(fabs(x[i]));
}

/* Expects 1/√hi and 1/√lo where the bounds are to go. */
LOOP int64_t inverse_roots(
    npy_intp count, const Value *a, double least, double *restrict lo, double *restrict negated_hi)
{
    const double *a_lo = a->low, *a_hi = a->high;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double low = lo[i], high = negated_hi[i];
        rare |= !(a_lo[i] >= least) | !(a_hi[i] < INFINITY) ? -1 : 0;
        widen(&low, &high, INVERSESQRT_ULPS, INVERSESQRT_ULPS);
        lo[i] = low;
        negated_hi[i] = -high;
    }
    return rare;
}

/* Bounds of 1/√a; nonzero where a is less than `least`. */
static int64_t inverse_root_bounds(
    npy_intp count, const Value *a, double least, double *lo, double *negated_hi)
{
    reciprocal_roots(count, a->high, lo);
    if (a->low == a->high) memcpy(negated_hi, lo, count * sizeof *lo);
    else reciprocal_roots(count, a->low, negated_hi);
    return inverse_roots(count, a, least, lo, negated_hi);
}

/* 1/√a where a is positive. */
static PyObject *inversesqrt(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Result *result = &pass.result;
    if (!begin(&pass, args, given, 1)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    for (npy_intp start = 0; at_block(&pass, start, 1); start += BLOCK) {
        result->rare = inverse_root_bounds(
            pass.count, &pass.a, SMALLEST_DENORMAL, pass.lo, pass.negated_hi);
        end_block(&pass, start);
    }
    return finished(&pass);
}

LOOP void roots(
    npy_intp count, const Value *a, const double *least, const double *greatest,
    double *restrict lo, double *restrict negated_hi)
{
    const double *a_hi = a->high;
    for (npy_intp i = 0; i < count; i++) {
        double low = 1.0 / greatest[i], high = smaller(1.0 / least[i], LARGEST);
        widen(&low, &high, DIVISION_ULPS, DIVISION_ULPS);
        lo[i] = low;
        negated_hi[i] = a_hi[i] <= 0.0 ? 0.0 : -high;
    }
}

/* √a as 1/(1/√a), where a is not negative. */
static PyObject *square_root(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Result *result = &pass.result;
    ALIGNED double least[BLOCK], greatest[BLOCK];
    if (!begin(&pass, args, given, 1)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    for (npy_intp start = 0; at_block(&pass, start, 1); start += BLOCK) {
        result->rare = inverse_root_bounds(
            pass.count, &pass.a, 0.0, pass.lo, pass.negated_hi);
        narrow(pass.count, 0, pass.lo, pass.negated_hi, least, greatest);
        roots(pass.count, &pass.a, least, greatest, pass.lo, pass.negated_hi);
        end_block(&pass, start);
    }
    return finished(&pass);
}

#endif
