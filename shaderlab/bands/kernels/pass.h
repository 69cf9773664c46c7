/* A pass over one or two bands, block by block. */

#ifndef SHADERLAB_PASS_H
#define SHADERLAB_PASS_H

typedef struct {
    Value a, b;
    PyObject *bands[2];
    Shape shape;
    Result result;
    int rearrange, tiny, minus;
    npy_intp count;
    /* What the blocks of an operation take besides. */
    double steps;
    ALIGNED double lo[BLOCK], negated_hi[BLOCK];
} Pass;

/* Reads one or two bands; false where the NumPy code must do it. */
static int begin(Pass *pass, PyObject *const *args, Py_ssize_t given, int count)
{
    memset(&pass->shape, 0, sizeof pass->shape);
    memset(&pass->result, 0, sizeof pass->result);
    pass->tiny = 0;
    if (given != count || !read_value(&pass->a, args[0])) return 0;
    if (count == 2 && !read_value(&pass->b, args[1])) return 0;
    for (int k = 0; k < 2; k++) pass->bands[k] = k < count ? args[k] : NULL;
    PyObject *rules = SLOT(args[0], bands.rules);
    if (!Py_IS_TYPE(rules, rule_sets.type)) return 0;
    pass->result.flush = is_rule(rules, rule_sets.flush);
    pass->rearrange = is_rule(rules, rule_sets.rearrange);
    pass->result.count = 1.0;
    if (!broadcast_value(&pass->shape, &pass->a)) return 0;
    if (count == 2 && !broadcast_value(&pass->shape, &pass->b)) return 0;
    if (!pass->shape.size) return 0;
    prepare_value(&pass->a, &pass->shape);
    if (count == 2) prepare_value(&pass->b, &pass->shape);
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
    if (pass->tiny) load_reach(&pass->a, start, pass->count);
    if (pass->tiny && bands == 2) load_reach(&pass->b, start, pass->count);
    return 1;
}

static void end_block(Pass *pass, npy_intp start)
{
    Result *result = &pass->result;
    result->differ |= narrow(pass->count, result->flush, pass->lo, pass->negated_hi,
                             result->low + start, result->high + start);
}

/* Does a block of an operation; returns what is rare in it. */
typedef int64_t (*Block)(Pass *pass, npy_intp start);

/* Makes room for the reach of tiny terms; -1 with an exception where there is none. */
static int reach_too(Pass *pass)
{
    Result *result = &pass->result;
    pass->tiny = 1;
    result->rare = result->differ = 0;
    result->reach = new_array(&pass->shape, &result->reached);
    if (!result->reach) drop(result);
    return result->reach ? 0 : -1;
}

/* Does all blocks, and once more with the reach of terms where some are tiny; `tiny` where they are
 * known to be. -1 with an exception where there is no room. */
static int run(Pass *pass, int bands, Block block, int tiny)
{
    Result *result = &pass->result;
    if (tiny && reach_too(pass)) return -1;
    for (;;) {
        for (npy_intp start = 0; at_block(pass, start, bands); start += BLOCK) {
            result->rare = block(pass, start);
            end_block(pass, start);
        }
        if (pass->tiny || result->rare != TINY_TERMS) return 0;
        if (reach_too(pass)) return -1;
    }
}

/* Where nothing is rearranged, terms are of no account. */
static void drop_terms(Result *result)
{
    Py_CLEAR(result->mag);
    Py_CLEAR(result->slack);
    Py_CLEAR(result->reach);
}

/* The band with these flags, which are taken over; None where something was rare. */
static PyObject *flagged(Pass *pass, PyObject *flags)
{
    Result *result = &pass->result;
    PyObject *terms = NULL;
    if (!succeeded(result)) {
        Py_XDECREF(flags);
        Py_RETURN_NONE;
    }
    if (!flags) {
        drop(result);
        return NULL;
    }
    if (result->mag)
        terms = new_terms(result->mag, result->slack, (long)result->count, result->reach);
    return new_band(result->lo, result->hi, SLOT(pass->bands[0], bands.rules), flags, terms);
}

/* The band with the flags of those that it was made of; None where something was rare. */
static PyObject *finished(Pass *pass)
{
    if (pass->result.rare) return flagged(pass, NULL);
    PyObject **made_of = pass->bands;
    if (made_of[1]) return flagged(pass, joint_flags(made_of[0], made_of[1]));
    return flagged(pass, Py_NewRef(SLOT(made_of[0], bands.flags)));
}

#endif
