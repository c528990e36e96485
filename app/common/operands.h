/* SPDX-License-Identifier: Apache-2.0 */
/* The inputs that a command line names. */
#ifndef APP_OPERANDS_H
#define APP_OPERANDS_H

/* What is left of the command line after the options. */
struct operands {
    char **items; /* allocated; free with operands_free */
    int n;
    char **rest; /* what followed "--", within argv; also in items unless the command
                    keeps_rest */
    int n_rest;
    const char *
        *given; /* names of the command's own options that were given; allocated */
    int n_given;
    /* An option that was given twice with two texts, the one that counts and the other;
     * NULL: there is none. */
    const char *twice, *counts, *dropped;
};

#endif
