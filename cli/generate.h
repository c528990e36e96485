/* SPDX-License-Identifier: Apache-2.0 */
/* Manual page and shell completion, made from the same tables as help.h. */
#ifndef CLI_GENERATE_H
#define CLI_GENERATE_H

/* rackfocus.1 and the completion of three shells on stdout; the build installs them. */
void generate_man(void);
void generate_completion(void); /* bash */
void generate_fish(void);
void generate_zsh(void);

#endif
