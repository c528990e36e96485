/* SPDX-License-Identifier: Apache-2.0 */
/* The manual page and the bash completion. */
#include "generate.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "console/cli.h"
#include "console/help.h"
#include "rackfocus/rackfocus.h"

/* ---- manual page ---------------------------------------------------------------- */

/* Text with what is special to roff escaped. */
static void print_roff(const char *text)
{
    for (bool is_line_start = true; *text; text++) {
        if (is_line_start && (*text == '.' || *text == '\''))
            fputs("\\&", stdout);
        is_line_start = *text == '\n';
        if (*text == '-')
            fputs("\\-", stdout);
        else if (*text == '\\')
            fputs("\\e", stdout);
        else if (text[0] == '\n' && text[1] == '\n') {
            fputs("\n.PP\n", stdout);
            text++;
            is_line_start = true;
        } else
            putchar(*text);
    }
}

static void print_section(const char *kind, const char *title)
{
    printf("%s \"", kind);
    print_roff(title);
    printf("\"\n");
}

static void print_upper_section(const char *title)
{
    printf(".SH ");
    for (; *title; title++)
        putchar(toupper((unsigned char)*title));
    putchar('\n');
}

static void print_man_option(const struct option *option)
{
    printf(".TP\n\\fB");
    if (option->letter)
        printf("\\-%c\\fR, \\fB", option->letter);
    printf("\\-\\-");
    print_roff(option->name);
    printf("\\fR");
    if (option->value) {
        printf(" \\fI");
        print_roff(option->value);
        printf("\\fR");
    }
    putchar('\n');
    print_roff(option->help);
    putchar('\n');
}

static void print_man_param(const struct rf_param_info *info)
{
    char synopsis[96], range[160];
    help_param_synopsis(info, synopsis, sizeof(synopsis));
    help_param_range(info, range, sizeof(range));
    printf(".TP\n.B ");
    print_roff(synopsis);
    putchar('\n');
    print_roff(info->help);
    printf("\n(");
    print_roff(range);
    printf("; attribute ");
    print_roff(info->attribute);
    printf(")\n");
    for (int i = 0; i < info->n_choices; i++) {
        printf(".br\n\\fB");
        print_roff(info->choices[i].name);
        printf("\\fR: ");
        print_roff(info->choices[i].help);
        putchar('\n');
    }
}

static void print_man_params(void)
{
    size_t n;
    const struct rf_param_info *params = rf_param_list(&n);
    printf(
        ".SH PARAMETERS\n"
        "Sub\\-commands that filter or describe a lens accept all of these. Each may "
        "also stand\nin the header of the file, as the attribute named.\n");
    for (int group = 0; group < HELP_N_GROUPS; group++) {
        print_section(".SS", help_group_title(group));
        for (size_t i = 0; i < n; i++)
            if ((int)params[i].group == group)
                print_man_param(&params[i]);
    }
}

static void print_man_accepted_params(const struct command *command)
{
    size_t n;
    const struct rf_param_info *params = rf_param_list(&n);
    printf(".PP\nAccepts every parameter of the section PARAMETERS");
    for (size_t i = 0; i < n; i++) {
        if (!help_has_option(command, params[i].key))
            continue;
        printf(", but \\-\\-");
        print_roff(params[i].key);
        printf(" is its own");
    }
    printf(".\n");
}

static void print_man_command(const struct command *command)
{
    print_section(".SS", command->name);
    printf(".B rackfocus %s\n", command->name);
    print_roff(command->usage);
    printf("\n.PP\n");
    print_roff(command->description);
    putchar('\n');
    for (size_t i = 0; i < command->n_options; i++)
        print_man_option(&command->options[i]);
    if (command->takes_params)
        print_man_accepted_params(command);
    if (command->examples) {
        printf(".PP\nExamples:\n.PP\n.nf\n.RS 4\n");
        print_roff(command->examples);
        printf("\n.RE\n.fi\n");
    }
}

static const char header_text[] =
    "A file of passes can carry all that the filter needs, so that no option is "
    "necessary. The command line wins over the header, the header over the default. "
    "Every parameter is read from the attribute named beside it (a number, or a string "
    "for the kinds). Where such an attribute is missing, the standard ones count: "
    "aperture (f-number), focus (metres, times the unit scale), nominalFocalLength or "
    "pinholeFocalLength (mm), sensorOverallDimensions (mm, width and height of the "
    "sensor), and the pixel aspect ratio; then what V-Ray (cameraFocalLength, "
    "cameraFov, "
    "cameraFNumber, cameraTargetDistance) and Unreal (unreal/.../focalLength, "
    "sensorWidth, fstop, focalDistance) say of their cameras, and the angle of view "
    "by worldToCamera and worldToNDC.\n\n"
    "Where the header gives the lens radius and the command line an f-stop or a focal "
    "length, the radius is multiplied by the old over the new f-stop and by the new "
    "over the old focal length; if the header lacks the old value, radius = focal "
    "length / (2 f-stop) is used, and if that is not known either, it is an error. A "
    "focal length in pixels gives way to --focal-length and --sensor-width "
    "likewise.\n\n"
    "A filtered picture carries rackfocus:filtered, the version and the parameters "
    "that made it, and those attributes above that say another lens than the passes "
    "had; the standard ones stay as they were.";

void generate_man(void)
{
    size_t n;
    const struct command *const *commands = command_list(&n);
    printf(".TH RACKFOCUS 1 \"\" \"rackfocus %s\" \"User Commands\"\n", rf_version());
    printf(".SH NAME\nrackfocus \\- depth of field after the render\n");
    printf(".SH SYNOPSIS\n.B rackfocus\n.I COMMAND\n[options]\n");
    print_upper_section("description");
    print_roff("Turns a pinhole render (colour and depth) into the picture that the "
               "scene's own lens would have made.");
    putchar('\n');
    print_upper_section("commands");
    for (size_t i = 0; i < n; i++)
        print_man_command(commands[i]);
    print_section(".SS", "help");
    printf(".B rackfocus help\n[COMMAND]\n.PP\nShows the options of a command.\n");
    print_man_params();
    print_upper_section("header attributes");
    print_roff(header_text);
    putchar('\n');
    print_upper_section("exit status");
    printf("0: done. 1: failed. 2: wrong usage. 130: interrupted; partial output was "
           "removed.\n");
}

/* ---- bash completion ------------------------------------------------------------ */

static void print_words_of_command(const struct command *command)
{
    for (size_t i = 0; i < command->n_options; i++) {
        printf(" --%s", command->options[i].name);
        if (command->options[i].letter)
            printf(" -%c", command->options[i].letter);
    }
    size_t n = 0;
    const struct rf_param_info *params = rf_param_list(&n);
    for (size_t i = 0; command->takes_params && i < n; i++) {
        printf(" --%s", params[i].key);
        if (params[i].type == RF_TYPE_BOOL)
            printf(" --no-%s", params[i].key);
    }
}

/* Cases of `command:previous word`: what the value of an option can be, a choice, a
 * file or nothing that could be completed. */
static void print_option_case(const char *command, const struct option *option)
{
    if (option->kind == OPTION_FLAG)
        return;
    printf("    %s:--%s", command, option->name);
    if (option->letter)
        printf(" | %s:-%c", command, option->letter);
    printf(") ");
    if (option->choices) {
        printf("words='");
        for (const char *c = option->choices; *c; c++)
            putchar(*c == '|' ? ' ' : *c);
        printf("' ;;\n");
    } else {
        printf("%s ;;\n", option->kind == OPTION_FILE ? "files=1" : "return 0");
    }
}

static void print_param_case(const struct rf_param_info *info)
{
    if (info->type == RF_TYPE_BOOL)
        return;
    printf("    *:--%s) ", info->key);
    if (info->choices) {
        printf("words='");
        for (int k = 0; k < info->n_choices; k++)
            printf("%s%s", k ? " " : "", info->choices[k].name);
        printf("' ;;\n");
    } else {
        printf("return 0 ;;\n");
    }
}

/* A command's own options first, since they hide parameters. */
static void print_value_cases(void)
{
    size_t n_commands, n;
    const struct command *const *commands = command_list(&n_commands);
    const struct rf_param_info *params = rf_param_list(&n);
    for (size_t i = 0; i < n_commands; i++)
        for (size_t k = 0; k < commands[i]->n_options; k++)
            print_option_case(commands[i]->name, &commands[i]->options[k]);
    for (size_t i = 0; i < n; i++)
        print_param_case(&params[i]);
}

/* The words that may follow "help", and the options of each sub-command. */
static void print_word_cases(void)
{
    size_t n;
    const struct command *const *commands = command_list(&n);
    printf("    help:*) words='");
    for (size_t i = 0; i < n; i++)
        printf("%s%s", i ? " " : "", commands[i]->name);
    printf(
        "' ;;\n"
        "    esac\n"
        "    if [ -z \"$words$files\" ] && [ \"${current#-}\" != \"$current\" ]; then\n"
        "        case \"$command\" in\n");
    for (size_t i = 0; i < n; i++) {
        printf("        %s) words='", commands[i]->name);
        print_words_of_command(commands[i]);
        printf("' ;;\n");
    }
    printf("        esac\n"
           "    fi\n");
}

static const char completion_head[] =
    "# Completion of rackfocus for bash; generated, do not edit.\n"
    "_rackfocus()\n{\n"
    "    local current=${COMP_WORDS[COMP_CWORD]}\n"
    "    local previous=${COMP_WORDS[COMP_CWORD-1]}\n"
    "    local command=${COMP_WORDS[1]} words='' files=''\n"
    "    COMPREPLY=()\n"
    "    # Bash splits --key=value at the sign.\n"
    "    if [ \"$current\" = '=' ]; then\n"
    "        current=''\n"
    "    elif [ \"$previous\" = '=' ]; then\n"
    "        previous=${COMP_WORDS[COMP_CWORD-2]}\n"
    "    fi\n"
    "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
    "        COMPREPLY=($(compgen -W 'help";

static const char completion_tail[] =
    "    if [ -n \"$words\" ]; then\n"
    "        COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
    "    else\n"
    "        compopt -o filenames 2>/dev/null\n"
    "        COMPREPLY=($(compgen -f -- \"$current\"))\n"
    "    fi\n"
    "}\n"
    "complete -F _rackfocus rackfocus\n";

void generate_completion(void)
{
    size_t n;
    const struct command *const *commands = command_list(&n);
    fputs(completion_head, stdout);
    for (size_t i = 0; i < n; i++)
        printf(" %s", commands[i]->name);
    printf(" --help --version' -- \"$current\"))\n"
           "        return 0\n"
           "    fi\n"
           "    case \"$command:$previous\" in\n");
    print_value_cases();
    print_word_cases();
    fputs(completion_tail, stdout);
}
