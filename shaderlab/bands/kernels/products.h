/* Products and squares. */

#ifndef SHADERLAB_PRODUCTS_H
#define SHADERLAB_PRODUCTS_H

/* `steps` times the rounding among the terms is added; 0 for plain values, which have none. */
LOOP int64_t multiply_block(
    npy_intp count, const Value *a, const Value *b, double steps, double *restrict lo,
    double *restrict negated_hi,
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
    npy_intp count, const Value *a, double steps, double *restrict lo, double *restrict negated_hi,
    double *restrict size)
{
    const double *a_lo = a->low, *a_hi = a->high;
    double relative = RELATIVE_STEP;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double first = a_lo[i] * a_lo[i], second = a_hi[i] * a_hi[i];
        double one_sided = (a_lo[i] < 0.0) & (a_hi[i] > 0.0) ? 0.0 : 1.0;
        double low = one_sided * smaller(first, second), high = larger(first, second);
        double mag = smaller(high, LARGEST);
        double step = steps * (relative * mag);
        lo[i] = larger(low - step, 0.0);
        negated_hi[i] = -(high + step);
        size[i] = mag;
        rare |= (high == INFINITY) | ((mag > 0.0) & (mag < TINY)) ? -1 : 0;
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

#endif
