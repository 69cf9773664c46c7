/* Bands, their terms and their rules as Python objects: read and made through their slots. */

#ifndef SHADERLAB_OBJECTS_H
#define SHADERLAB_OBJECTS_H

/* The classes, and where in their instances the slots lie; and the flags that are set nowhere. */
static struct {
    PyTypeObject *type;
    Py_ssize_t lo, hi, rules, flags, terms, direction, size;
} bands;
static struct {
    PyTypeObject *type;
    Py_ssize_t mag, slack, count, reach, least;
} term_lists;
static struct {
    PyTypeObject *type;
    Py_ssize_t rearrange, flush;
} rule_sets;
static PyObject *nowhere;

#define SLOT(object, offset) (*(PyObject **)((char *)(object) + (offset)))

static inline int is_band(PyObject *object)
{
    return bands.type && PyObject_TypeCheck(object, bands.type);
}

/* Where a slot lies; -1 with an exception if there is none of this name. */
static Py_ssize_t offset_of(PyTypeObject *type, const char *name)
{
    PyObject *found = PyObject_GetAttrString((PyObject *)type, name);
    if (!found) return -1;
    Py_ssize_t offset = -1;
    if (Py_IS_TYPE(found, &PyMemberDescr_Type)) {
        PyMemberDef *member = ((PyMemberDescrObject *)found)->d_member;
        if (member->type == T_OBJECT_EX) offset = member->offset;
    }
    Py_DECREF(found);
    if (offset < 0) PyErr_Format(PyExc_TypeError, "%s.%s is no slot", type->tp_name, name);
    return offset;
}

typedef struct {
    const char *name;
    Py_ssize_t *offset;
} Slot;

static int find_slots(PyObject *type, PyTypeObject **kept, const Slot *slots)
{
    if (!PyType_Check(type)) {
        PyErr_SetString(PyExc_TypeError, "no class");
        return -1;
    }
    for (; slots->name; slots++)
        if ((*slots->offset = offset_of((PyTypeObject *)type, slots->name)) < 0) return -1;
    *kept = (PyTypeObject *)Py_NewRef(type);
    return 0;
}

/* use_bands(Band, Terms, Rules, flags that are set nowhere). */
static PyObject *use_bands(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    const Slot of_bands[] = {
        {"lo", &bands.lo}, {"hi", &bands.hi}, {"rules", &bands.rules}, {"flags", &bands.flags},
        {"terms", &bands.terms}, {"direction", &bands.direction}, {"_size", &bands.size}, {0}};
    const Slot of_terms[] = {
        {"abs_sum", &term_lists.mag}, {"slack", &term_lists.slack}, {"count", &term_lists.count},
        {"flush_gain", &term_lists.reach}, {"_least", &term_lists.least}, {0}};
    const Slot of_rules[] = {
        {"rearrange", &rule_sets.rearrange}, {"flush", &rule_sets.flush}, {0}};
    if (given != 4 || !PyTuple_Check(args[3])) {
        PyErr_SetString(PyExc_TypeError, "use_bands() takes three classes and flags");
        return NULL;
    }
    if (find_slots(args[1], &term_lists.type, of_terms)) return NULL;
    if (find_slots(args[2], &rule_sets.type, of_rules)) return NULL;
    if (find_slots(args[0], &bands.type, of_bands)) return NULL;
    nowhere = Py_NewRef(args[3]);
    Py_RETURN_NONE;
}

static inline int is_rule(PyObject *rules, Py_ssize_t rule)
{
    return SLOT(rules, rule) == Py_True;
}

/* Whether flags are set nowhere at all. */
static int flagless(PyObject *flags)
{
    if (flags == nowhere) return 1;
    PyObject *no = PyTuple_GET_ITEM(nowhere, 0);
    for (Py_ssize_t i = 0; i < PyTuple_GET_SIZE(flags); i++)
        if (PyTuple_GET_ITEM(flags, i) != no) return 0;
    return 1;
}

/* The flags of two bands together. */
static PyObject *joint_flags(PyObject *one, PyObject *other)
{
    PyObject *flags = SLOT(one, bands.flags), *others = SLOT(other, bands.flags);
    if (flags == others || flagless(others)) return Py_NewRef(flags);
    if (flagless(flags)) return Py_NewRef(others);
    PyObject *joint = PyTuple_New(PyTuple_GET_SIZE(flags));
    for (Py_ssize_t i = 0; joint && i < PyTuple_GET_SIZE(flags); i++) {
        PyObject *both = PyNumber_Or(PyTuple_GET_ITEM(flags, i), PyTuple_GET_ITEM(others, i));
        if (!both) Py_CLEAR(joint);
        else PyTuple_SET_ITEM(joint, i, both);
    }
    return joint;
}

static inline PyObject *or_none(void *object) { return object ? object : Py_NewRef(Py_None); }

/* Takes over all arguments, of which mag may be NULL for none, and slack and reach. */
static PyObject *new_terms(void *mag, void *slack, long count, void *reach)
{
    PyObject *made = term_lists.type->tp_alloc(term_lists.type, 0);
    if (!made) return NULL;
    SLOT(made, term_lists.mag) = mag;
    SLOT(made, term_lists.slack) = or_none(slack);
    SLOT(made, term_lists.count) = PyLong_FromLong(count);
    SLOT(made, term_lists.reach) = or_none(reach);
    SLOT(made, term_lists.least) = Py_NewRef(Py_None);
    return made;
}

/* Takes over all arguments but the rules; `terms` may be NULL for none. */
static PyObject *new_band(void *lo, void *hi, PyObject *rules, PyObject *flags, PyObject *terms)
{
    PyObject *made = bands.type->tp_alloc(bands.type, 0);
    if (!made) return NULL;
    SLOT(made, bands.lo) = lo;
    SLOT(made, bands.hi) = hi;
    SLOT(made, bands.rules) = Py_NewRef(rules);
    SLOT(made, bands.flags) = flags;
    SLOT(made, bands.terms) = or_none(terms);
    SLOT(made, bands.direction) = Py_NewRef(Py_None);
    SLOT(made, bands.size) = Py_NewRef(Py_None);
    return made;
}

#endif
