"""Reads a report page with Python's own HTML and JSON parsers and prints what it finds as JSON, one document.

usage: check_page.py FILE.html
{"problems": [...], "title": text, "data": the embedded document without its frames}
A page is clean when nothing in it may load anything, and its policy allows exactly the script and style it carries.
"""
import base64
import hashlib
import html.parser
import json
import re
import sys

LOADING_TAGS = {"link", "img", "iframe", "frame", "object", "embed", "audio", "video", "source", "track", "base", "form", "area", "a"}
LOADING_ATTRIBUTES = {"src", "href", "srcset", "action", "formaction", "data", "poster", "background", "xlink:href", "ping", "manifest"}
POLICY = re.compile(r"default-src 'none'; script-src '(sha256-[^' ]+)'; style-src '(sha256-[^' ]+)'; base-uri 'none'; form-action 'none'")


def digest(text):
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode()


class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.problems, self.policies, self.texts, self.open = [], [], {}, None

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag in LOADING_TAGS:
            self.problems.append(f"element <{tag}>")
        for name, value in attributes.items():
            if name in LOADING_ATTRIBUTES or name == "style" or name.startswith("on") or "url(" in (value or ""):
                self.problems.append(f"attribute {name} of <{tag}>")
        if tag == "meta" and attributes.get("http-equiv") == "Content-Security-Policy":
            self.policies.append(attributes["content"])
        elif tag == "meta" and "http-equiv" in attributes:
            self.problems.append("another http-equiv")
        if tag in ("script", "style", "title"):
            self.open = "data" if attributes.get("type") == "application/json" else tag
            self.texts.setdefault(self.open, []).append("")

    def handle_endtag(self, tag):
        if tag in ("script", "style", "title"):
            self.open = None

    def handle_data(self, data):
        if self.open:
            self.texts[self.open][-1] += data


def main():
    page = Page()
    with open(sys.argv[1], encoding="utf-8", newline="") as file:
        page.feed(file.read())
    page.close()
    problems = page.problems
    for kind in ("script", "style", "title", "data"):
        if len(page.texts.get(kind, [])) != 1:
            problems.append(f"{len(page.texts.get(kind, []))} elements of kind {kind}")
    policy = POLICY.fullmatch(page.policies[0]) if len(page.policies) == 1 else None
    if policy is None:
        problems.append(f"policy: {page.policies}")
    elif [policy[1], policy[2]] != [digest(page.texts["script"][0]), digest(page.texts["style"][0])]:
        problems.append("the policy's hashes are not those of the script and the style")
    if re.search(r"@import|url\(", page.texts["style"][0]):
        problems.append("the style loads something")
    document = json.loads(page.texts["data"][0])
    for run in document["runs"]:
        run["frames"] = {name: len(values) for name, values in run["frames"].items()}
    print(json.dumps({"problems": problems, "title": page.texts["title"][0], "data": document}))


if __name__ == "__main__":
    main()
