/* Rounding outward to the float32 grid, and ULPs; the twin of rounding.py.
 *
 * Upper bounds are kept negated wherever the processor rounds downward: -(-a - b) is a + b rounded
 * upward, so that one direction serves both ends. */

#ifndef SHADERLAB_ROUNDING_H
#define SHADERLAB_ROUNDING_H

/* The loops are built for wider registers too, and chosen on loading; older compilers know no name
 * for the widest. */
#if !defined(__x86_64__) || !defined(__linux__) || !defined(__GLIBC__) || defined(__clang__)
#define LOOP __attribute__((noinline)) static
#elif __GNUC__ < 12
#define LOOP __attribute__((noinline, target_clones("avx2", "default"))) static
#else
#define LOOP __attribute__((noinline, target_clones("arch=x86-64-v4", "avx2", "default"))) static
#endif

#define SMALLEST_NORMAL 0x1p-126
#define SMALLEST_DENORMAL 0x1p-149
#define LARGEST 0x1.fffffep127
#define RELATIVE_STEP (0x1p-23 * (1.0 + 0x1p-20))
#define FLOAT64_ERROR 0x1p-50
#define TINY 0x1p-60
#define FAR_AWAY 0x1p600

/* What a loop finds rare: what the NumPy code must do, and terms of which products may be denormal,
 * which another loop does. */
#define ODD 1
#define TINY_TERMS 2

static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

/* Whether bounds are no finite numbers. */
static inline int unbounded(double lo, double hi) { return !(lo > -INFINITY) | !(hi < INFINITY); }

/* What one rounding among terms may change; `flushed` is what a flushed product among tiny ones
 * may. */
static inline double step_of(double mag, double flushed, int tiny)
{
    if (!tiny) return RELATIVE_STEP * mag;
    return mag > 0.0 ? larger(RELATIVE_STEP * mag, flushed) : 0.0;
}

static inline int64_t rare_of(int odd, double mag)
{
    return (odd ? ODD : 0) | ((mag > 0.0) & (mag < TINY) ? TINY_TERMS : 0);
}

/* A loop in two versions: for terms of which none is tiny, and for any. */
#define VERSION static inline __attribute__((always_inline))

static inline int64_t bits_of(double x)
{
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double ulp(double x)
{
    double size = smaller(larger(fabs(x), SMALLEST_DENORMAL), LARGEST);
    int64_t bits = (bits_of(size) - 1) & 0x7FF0000000000000;
    memcpy(&size, &bits, sizeof bits);
    return larger(size * 0x1p-23, SMALLEST_DENORMAL);
}

/* Bounds, no NaN among them, moved out by some ULP, not past zero. */
static inline void widen(double *lo, double *hi, double ulps_lo, double ulps_hi)
{
    double out_lo = ulps_lo * ulp(*lo) + FLOAT64_ERROR * smaller(fabs(*lo), LARGEST);
    double out_hi = ulps_hi * ulp(*hi) + FLOAT64_ERROR * smaller(fabs(*hi), LARGEST);
    double most = larger(out_lo, out_hi);
    double more_lo = smaller(most, out_lo * (*lo > 0.0 ? 2.0 : 1.0));
    double more_hi = smaller(most, out_hi * (*hi < 0.0 ? 2.0 : 1.0));
    double least = *lo < 0.0 ? -FAR_AWAY : 0.0, greatest = *hi > 0.0 ? FAR_AWAY : 0.0;
    *lo = larger(*lo - more_lo, least);
    *hi = smaller(*hi + more_hi, greatest);
}

/* The direction in which the processor rounds; the library's own call takes longer than a short
 * loop. */
#ifdef __x86_64__
#include <immintrin.h>
static inline void round_downward(void)
{
    _mm_setcsr((_mm_getcsr() & ~(unsigned)_MM_ROUND_MASK) | _MM_ROUND_DOWN);
}
static inline void round_to_nearest(void)
{
    _mm_setcsr(_mm_getcsr() & ~(unsigned)_MM_ROUND_MASK);
}
#else
static inline void round_downward(void) { fesetround(FE_DOWNWARD); }
static inline void round_to_nearest(void) { fesetround(FE_TONEAREST); }
#endif

/* Of all positive numbers in their order, which is that of their bits, how many are flushed. */
static uint64_t flushed_numbers(int flush)
{
    return flush ? (uint64_t)bits_of(SMALLEST_NORMAL) - 1 : 0;
}

/* A bound rounded to float32 in the processor's direction; 0 for the first positive numbers. */
static inline double narrowed_bound(double bound, uint64_t flushed)
{
    double narrow = (float)bound;
    uint64_t bits = (uint64_t)bits_of(narrow);
    bits = bits - 1 < flushed ? 0 : bits;
    memcpy(&narrow, &bits, sizeof bits);
    return narrow;
}

/* Called while the processor rounds downward. The upper bound comes negated. */
LOOP int64_t narrowed(
    npy_intp count, int flush, const double *lo, const double *negated_hi, double *restrict out_lo,
    double *restrict out_hi)
{
    int64_t differ = 0;
    uint64_t flushed = flushed_numbers(flush);
    for (npy_intp i = 0; i < count; i++) {
        double low = narrowed_bound(lo[i], flushed);
        double high = -narrowed_bound(negated_hi[i], flushed);
        out_lo[i] = low;
        out_hi[i] = high;
        differ |= low != high ? -1 : 0;
    }
    return differ;
}

/* Rounds a block outward; nonzero if two bounds differ. */
static int64_t narrow(
    npy_intp count, int flush, const double *lo, const double *negated_hi, double *restrict out_lo,
    double *restrict out_hi)
{
    round_downward();
    int64_t differ = narrowed(count, flush, lo, negated_hi, out_lo, out_hi);
    round_to_nearest();
    return differ;
}

LOOP void summed(
    npy_intp count, const double *a_lo, const double *a_hi, const double *b_lo, const double *b_hi,
    double *restrict lo, double *restrict negated_hi)
{
    for (npy_intp i = 0; i < count; i++) {
        lo[i] = a_lo[i] + b_lo[i];
        negated_hi[i] = -a_hi[i] - b_hi[i];
    }
}

/* Sums rounded outward to float64. */
static void sum(
    npy_intp count, const double *a_lo, const double *a_hi, const double *b_lo, const double *b_hi,
    double *restrict lo, double *restrict negated_hi)
{
    round_downward();
    summed(count, a_lo, a_hi, b_lo, b_hi, lo, negated_hi);
    round_to_nearest();
}

#endif
