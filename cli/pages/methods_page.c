/* SPDX-License-Identifier: Apache-2.0 */
#include "pages/methods_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/text_file.h"
#include "console/cli.h"
#include "pages/html.h"
#include "path.h"
#include "rackfocus/rackfocus.h"

/* Nothing is fetched but the pictures beside the page. */
static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width\">\n<title>";
static const char style[] =
    "</title>\n<style>\n"
    "body{font:16px/1.4 sans-serif;background:#1c1c1c;color:#eee;margin:1em}\n"
    "p{color:#bbb;margin:.3em 0}\n"
    ".stage{position:relative;overflow:auto;max-height:75vh;border:1px solid #444}\n"
    ".stage div{position:relative;width:max-content;touch-action:pan-y}\n"
    ".stage img{display:block;image-rendering:pixelated}\n"
    "#right-picture{position:absolute;left:0;top:0}\n"
    "#line{position:absolute;top:0;bottom:0;width:2px;background:#fff;"
    "pointer-events:none}\n"
    "#wipe{width:100%;margin:.6em 0}\n"
    "label{margin-right:1.5em;white-space:nowrap}\n"
    "table{border-collapse:collapse;margin-top:1em}\n"
    "td,th{padding:.15em .8em;text-align:right;border-bottom:1px solid #333}\n"
    "td:first-child,th:first-child{text-align:left}\n"
    "th button{all:unset;cursor:pointer;text-decoration:underline dotted}\n"
    "button:focus-visible,select:focus-visible{outline:2px solid #6cf}\n"
    "tr.left td:first-child::after{content:' \\25C0'}"
    "tr.right td:first-child::after{content:' \\25B6'}\n"
    "</style>\n<h1>";
static const char viewer[] =
    "<p><label>Left <select id=\"left\"></select></label>"
    "<label>Right <select id=\"right\"></select></label>"
    "<label><input type=\"checkbox\" id=\"error\"> Error</label>"
    "<label>Size <select id=\"zoom\"><option value=\"1\">1:1<option value=\"2\">2:1"
    "<option value=\"4\">4:1</select></label></p>\n"
    "<div class=\"stage\" id=\"stage\"><div><img id=\"left-picture\" alt=\"\">"
    "<img id=\"right-picture\" alt=\"\"><span id=\"line\"></span></div></div>\n"
    "<input type=\"range\" id=\"wipe\" min=\"0\" max=\"1000\" value=\"500\" "
    "aria-label=\"Where the left picture ends\">\n"
    "<noscript><p>The slider needs JavaScript; the pictures are in the folder beside "
    "this page.</p></noscript>\n";
static const char table_head[] =
    "<table id=\"table\"><thead><tr><th><button>method</button><th><button>time ms"
    "</button><th><button>tPSNR dB</button><th><button>FLIP</button><th><button>SSIM"
    "</button><th><button>energy %</button><th><button>leak "
    "%</button></thead><tbody>\n";
static const char notes[] =
    "</tbody></table>\n"
    "<p>A click on a line shows it on the right, with Shift on the left; a click on a "
    "heading sorts. tPSNR: 40 dB and more can hardly be told from the reference. FLIP: "
    "what the eye sees when both are shown in turn, 0 is alike. Leak: mean error where "
    "sharp colours can run out.</p>\n";
static const char script[] =
    "const by = id => document.getElementById(id);\n"
    "const rows = [...by('table').tBodies[0].rows];\n"
    "for (const side of ['left', 'right'])\n"
    "  for (const row of rows) by(side).add(new Option(row.dataset.name, "
    "row.dataset.file));\n"
    "const best = rows.reduce((a, b) => +b.dataset.db > +a.dataset.db ? b : a);\n"
    "by('left').value = 'reference'; by('right').value = best.dataset.file;\n"
    "function show() {\n"
    "  const scale = +by('zoom').value;\n"
    "  for (const side of ['left', 'right']) {\n"
    "    const picture = by(side + '-picture'), file = by(side).value;\n"
    "    const error = by('error').checked && file != 'reference' ? '_error' : '';\n"
    "    picture.src = FOLDER + '/' + file + error + '.png';\n"
    "    picture.alt = file.replace('_', ' ') + (error && ', error');\n"
    "    picture.width = WIDTH * scale; picture.height = HEIGHT * scale;\n"
    "    for (const row of rows) row.classList.toggle(side, row.dataset.file == "
    "file);\n"
    "  }\n"
    "  by('wipe').style.maxWidth = WIDTH * scale + 'px';\n"
    "  wipe();\n"
    "}\n"
    "function wipe() {\n"
    "  const x = by('wipe').value / 10;\n"
    "  by('right-picture').style.clipPath = `inset(0 0 0 ${x}%)`;\n"
    "  by('line').style.left = `calc(${x}% - 1px)`;\n"
    "}\n"
    "function drag(event) {\n"
    "  const box = by('left-picture').getBoundingClientRect();\n"
    "  by('wipe').value = 1000 * (event.clientX - box.left) / box.width; wipe();\n"
    "}\n"
    "by('stage').onpointerdown = event => { drag(event); event.preventDefault(); };\n"
    "by('stage').onpointermove = event => { if (event.buttons) drag(event); };\n"
    "by('wipe').oninput = wipe;\n"
    "for (const id of ['left', 'right', 'error', 'zoom']) by(id).onchange = show;\n"
    "for (const row of rows) row.onclick = event => {\n"
    "  by(event.shiftKey ? 'left' : 'right').value = row.dataset.file; show();\n"
    "};\n"
    "[...by('table').tHead.rows[0].cells].forEach((cell, column) => {\n"
    "  let sign = 1;\n"
    "  cell.onclick = () => {\n"
    "    const value = row => column ? parseFloat(row.cells[column].textContent) || 0\n"
    "                                : row.cells[0].textContent;\n"
    "    rows.sort((a, b) => sign * (value(a) < value(b) ? -1 : 1)); sign = -sign;\n"
    "    by('table').tBodies[0].append(...rows);\n"
    "  };\n"
    "});\n"
    "show();\n"
    "</script>\n";

static bool put(const char *folder, const char *name, const char *ending,
                const struct methods_subject *subject, const float *rgb,
                bool is_encoded, struct image_error *error)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s%s.png", folder, name, ending);
    return image_write_png(path, rgb, subject->width, subject->height, 3, 8, is_encoded,
                           error);
}

bool methods_page_put(const char *folder, const struct methods_subject *subject,
                      const struct methods_entry *entry, const float *picture,
                      const float *error_map, struct image_error *error)
{
    char name[sizeof entry->name] = "reference";
    if (entry)
        methods_file_name(entry, name, sizeof name);
    return put(folder, name, "", subject, picture, false, error) &&
           (!error_map || put(folder, name, "_error", subject, error_map, true, error));
}

struct page {
    const char *folder;
    const struct methods_subject *subject;
    const struct methods_entry *entries;
    int n_entries;
};

static void print_row(FILE *file, const struct methods_entry *entry)
{
    char name[sizeof entry->name], time[32] = "", leak[32] = "";
    const struct measures *m = &entry->measures;
    methods_file_name(entry, name, sizeof name);
    if (entry->method >= 0)
        snprintf(time, sizeof time, "%.1f", entry->time_s * 1e3);
    if (isfinite(entry->leak_percent))
        snprintf(leak, sizeof leak, "%.2f", entry->leak_percent);
    fprintf(file,
            "<tr data-name=\"%s\" data-file=\"%s\" data-db=\"%.4f\"><td>%s<td>%s<td>"
            "%.2f<td>%.4f<td>%.4f<td>%+.2f<td>%s\n",
            entry->name, name, fmin(m->tpsnr_db, 999), entry->name, time, m->tpsnr_db,
            entry->flip, m->ssim, 100 * (m->energy_ratio - 1), leak);
}

static void print_page(FILE *file, const void *data)
{
    const struct page *page = data;
    const struct methods_subject *subject = page->subject;
    fputs(head, file);
    html_print(file, subject->title);
    fputs(style, file);
    html_print(file, subject->title);
    fputs("</h1>\n<p>", file);
    html_print(file, subject->about);
    fprintf(file, ". rackfocus %s</p>\n", rf_version());
    fputs(viewer, file);
    fputs(table_head, file);
    fputs("<tr data-name=\"reference\" data-file=\"reference\" data-db=\"0\">"
          "<td>reference<td><td><td><td><td><td>\n",
          file);
    for (int i = 0; i < page->n_entries; i++)
        print_row(file, &page->entries[i]);
    fputs(notes, file);
    fputs("<script>\nconst FOLDER = \"", file);
    html_print_address(file, os_path_name(page->folder));
    fprintf(file, "\", WIDTH = %d, HEIGHT = %d;\n", (int)subject->width,
            (int)subject->height);
    fputs(script, file);
}

bool methods_page_write(const char *path, const char *folder,
                        const struct methods_subject *subject,
                        const struct methods_entry *entries, int n_entries,
                        struct image_error *error)
{
    struct page page = {folder, subject, entries, n_entries};
    return text_file_write(path, print_page, &page, error);
}
