/* forms: other forms of a mesh, in which everything that matters is the same. */
#ifndef TEST_SUPPORT_FORMS_H
#define TEST_SUPPORT_FORMS_H

#include "support/problems.h"

/** What is left of a mesh in another form. */
typedef enum test_form_kind {
    FORM_RENAMED, /* the same elements, formed by the same numbers */
    FORM_SHIFTED, /* coordinates differ by the same as before, exactly */
    FORM_ROUNDED, /* coordinates are rounded anew */
    FORM_FAR      /* and to a ten millionth of an edge */
} test_form_kind;

typedef struct test_form {
    const char *name;
    test_form_kind kind;
    void (*apply)(test_problem *p, unsigned seed);
} test_form;

/** Ends with a name that is NULL. */
extern const test_form test_forms[];

/** Whether a wish means the same in the form: boxes do not turn, and floats have few digits. */
int test_form_suits(const test_form *form, test_wish wish);

#endif
