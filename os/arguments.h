/* SPDX-License-Identifier: Apache-2.0 */
/* The command line. */
#ifndef OS_ARGUMENTS_H
#define OS_ARGUMENTS_H

/*
 * The arguments of main() as UTF-8, up to NULL, and their number; where the system has
 * them so, argv itself. Standard input and output pass bytes from then on, and a
 * standard stream that the caller closed fails when it is used, instead of being the
 * next file that is opened. First in a main(); what it returns lives as long as the
 * process.
 */
char **os_arguments(int *argc, char **argv);

#endif
