/* Sums of products along lines, without the products in memory: a dot product, a matrix times a
 * vector, a vector's squared length. */

#ifndef SHADERLAB_LINES_H
#define SHADERLAB_LINES_H

/* A block of rows of a line: its products, and their sum. */
typedef struct {
    ALIGNED double lo[MAX_TERMS][ROWS], negated_hi[MAX_TERMS][ROWS];
    ALIGNED double low[ROWS], negated_high[ROWS];
    /* The roundings between the partial sums, and what these do not take the sum past. */
    ALIGNED double between[ROWS], least[ROWS], negated_most[ROWS];
    double *size, *slack, *reach;
} Sums;

/* How lines are multiplied: `steps` times the rounding among the terms is added to each product;
 * `unit` is what a flushed one may change. */
typedef struct {
    double steps, unit;
    int terms, flush;
} Products;

/* What the factors are: values of each row, numbers that all rows share, or one value twice. */
typedef enum { EACH, SHARED, SQUARE } Kind;

typedef struct {
    double size, terms, positive, negative, reach;
    int64_t rare;
} Tally;

VERSION void multiply_term(
    const Products *how, const Elements *a, const Elements *b, npy_intp i, int j, Kind kind,
    int tiny, Tally *tally, Sums *restrict sums)
{
    double b_lo = b->low[j][i], b_hi = b->high[j][i], low, high, mag, reach = 0.0, flushed = 0.0;
    double out_low, negated_out, step;
    int odd;
    if (kind == SQUARE) {
        double first = b_lo * b_lo, second = b_hi * b_hi;
        low = ((b_lo < 0.0) & (b_hi > 0.0) ? 0.0 : 1.0) * smaller(first, second);
        high = larger(first, second);
        mag = smaller(high, LARGEST);
        if (tiny) reach = larger(b->reach[j][i] * b->reach[j][i], 1.0);
        flushed = SMALLEST_NORMAL * reach;
        step = how->steps * step_of(mag, flushed, tiny);
        out_low = larger(low - step, 0.0);
        negated_out = -(high + step);
        odd = high == INFINITY;
    } else {
        npy_intp at = kind == SHARED ? 0 : i;
        double a_lo = a->low[j][at], a_hi = kind == SHARED ? a_lo : a->high[j][at];
        double first = a_lo * b_lo, second = a_lo * b_hi;
        double third = a_hi * b_lo, fourth = a_hi * b_hi;
        low = smaller(smaller(first, second), smaller(third, fourth));
        high = larger(larger(first, second), larger(third, fourth));
        mag = a->size[j][at] * b->size[j][i];
        if (tiny) reach = larger(a->reach[j][at] * b->reach[j][i], 1.0);
        flushed = how->unit * reach;
        step = how->steps * step_of(mag, flushed, tiny);
        double below = low - step, above = high + step;
        double enough = how->steps > 1.0 ? mag * UNCANCELLED : 0.0;
        int safe = !tiny || (RELATIVE_STEP * mag >= flushed) | (mag == 0.0);
        out_low = (below < 0.0) & (low >= 0.0) & safe & (high >= enough) ? 0.0 : below;
        negated_out = (above > 0.0) & (high <= 0.0) & safe & (-low >= enough) ? 0.0 : -above;
        odd = !(fabs(first + second + (third + fourth) + mag) < INFINITY);
    }
    sums->lo[j][i] = out_low;
    sums->negated_hi[j][i] = negated_out;
    tally->size = j ? tally->size + mag : mag;
    tally->terms += mag > 0.0 ? 1.0 : 0.0;
    tally->positive = out_low >= 0.0 ? tally->positive : -INFINITY;
    tally->negative = negated_out >= 0.0 ? tally->negative : -INFINITY;
    /* A term that only fills up a line has none. */
    if (tiny) tally->reach += j < how->terms ? reach : 0.0;
    tally->rare |= rare_of(odd, tiny ? 0.0 : mag);
}

VERSION int64_t multiplied_lines(
    npy_intp count, const Products *how, const Elements *a, const Elements *b, int terms, Kind kind,
    int tiny, Sums *restrict sums)
{
    int64_t rare = 0;
    double unit = SMALLEST_NORMAL * (double)how->terms;
    double *restrict size = sums->size, *restrict slack = sums->slack, *restrict reach = sums->reach;
#pragma GCC ivdep
    for (npy_intp i = 0; i < count; i++) {
        Tally tally = {0};
        multiply_term(how, a, b, i, 0, kind, tiny, &tally, sums);
        multiply_term(how, a, b, i, 1, kind, tiny, &tally, sums);
        multiply_term(how, a, b, i, 2, kind, tiny, &tally, sums);
        if (terms > 3) multiply_term(how, a, b, i, 3, kind, tiny, &tally, sums);
        double step = tally.size > 0.0 ? step_of(tally.size, unit * tally.reach, tiny) : 0.0;
        /* All partial sums but the last may each lose a step. */
        sums->between[i] = larger(tally.terms - 2.0, 0.0) * step;
        slack[i] = tally.terms >= 2.0 ? step : 0.0;
        sums->least[i] = tally.positive;
        sums->negated_most[i] = tally.negative;
        size[i] = tally.size;
        if (tiny) reach[i] = tally.reach;
        rare |= tally.rare | rare_of(!(tally.size < INFINITY), tiny ? 0.0 : tally.size);
    }
    return rare;
}

/* Versions for three and for four terms. */
#define MULTIPLY_LINES(name, terms, kind, tiny)                                                    \
    LOOP int64_t name(                                                                             \
        npy_intp count, const Products *how, const Elements *a, const Elements *b, Sums *sums)     \
    {                                                                                              \
        return multiplied_lines(count, how, a, b, terms, kind, tiny, sums);                        \
    }
MULTIPLY_LINES(multiply_three, 3, EACH, 0)
MULTIPLY_LINES(multiply_four, 4, EACH, 0)
MULTIPLY_LINES(multiply_three_tiny, 3, EACH, 1)
MULTIPLY_LINES(multiply_four_tiny, 4, EACH, 1)
MULTIPLY_LINES(multiply_three_shared, 3, SHARED, 0)
MULTIPLY_LINES(multiply_four_shared, 4, SHARED, 0)
MULTIPLY_LINES(square_three, 3, SQUARE, 0)
MULTIPLY_LINES(square_four, 4, SQUARE, 0)
MULTIPLY_LINES(square_three_tiny, 3, SQUARE, 1)
MULTIPLY_LINES(square_four_tiny, 4, SQUARE, 1)

/* Adds up the products, each rounded outward; called while the processor rounds downward. */
LOOP void add_products(npy_intp count, int terms, int flush, Sums *sums)
{
    uint64_t flushed = flushed_numbers(flush);
    double (*restrict lo)[ROWS] = sums->lo, (*restrict hi)[ROWS] = sums->negated_hi;
    double *restrict low = sums->low, *restrict high = sums->negated_high;
    if (terms > 3)
        for (npy_intp i = 0; i < count; i++) {
            low[i] = narrowed_bound(lo[0][i], flushed) + narrowed_bound(lo[1][i], flushed)
                + narrowed_bound(lo[2][i], flushed) + narrowed_bound(lo[3][i], flushed);
            high[i] = narrowed_bound(hi[0][i], flushed) + narrowed_bound(hi[1][i], flushed)
                + narrowed_bound(hi[2][i], flushed) + narrowed_bound(hi[3][i], flushed);
        }
    else
        for (npy_intp i = 0; i < count; i++) {
            low[i] = narrowed_bound(lo[0][i], flushed) + narrowed_bound(lo[1][i], flushed)
                + narrowed_bound(lo[2][i], flushed);
            high[i] = narrowed_bound(hi[0][i], flushed) + narrowed_bound(hi[1][i], flushed)
                + narrowed_bound(hi[2][i], flushed);
        }
}

LOOP int64_t end_lines(npy_intp count, Sums *sums)
{
    double *restrict low = sums->low, *restrict high = sums->negated_high;
    const double *between = sums->between, *least = sums->least, *most = sums->negated_most;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        rare |= unbounded(low[i], -high[i]) ? ODD : 0;
        low[i] = larger(low[i] - between[i], least[i]) + 0.0;
        high[i] = larger(high[i] - between[i], most[i]);
    }
    return rare;
}

/* The sums of a block of a line, rounded outward into `low` and `high`; what is rare. `b` are its
 * elements, and so are `a` where there are others. */
static int64_t add_up(
    npy_intp count, const Products *how, Kind kind, int terms, int tiny, const Elements *a,
    const Elements *b, Sums *sums, double *low, double *high)
{
    typedef int64_t (*Multiplier)(
        npy_intp, const Products *, const Elements *, const Elements *, Sums *);
    static const Multiplier all[2][2][3] = {
        {{multiply_three, multiply_three_shared, square_three},
         {multiply_three_tiny, NULL, square_three_tiny}},
        {{multiply_four, multiply_four_shared, square_four},
         {multiply_four_tiny, NULL, square_four_tiny}}};
    int64_t rare = all[terms > 3][tiny][kind](count, how, a, b, sums);
    round_downward();
    add_products(count, terms, how->flush, sums);
    round_to_nearest();
    rare |= end_lines(count, sums);
    narrow(count, how->flush, sums->low, sums->negated_high, low, high);
    return rare;
}
#endif
