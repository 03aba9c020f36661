# embed: make a C file of other files: each becomes the bytes of a pl_asset (assets.h).
#
#   cmake -DOUT=assets.c -DASSETS=name=path;name=path|path;... -P embed.cmake
#
# An asset is the bytes of its files, one after another; without a path it is empty.
set(text "#include \"report/assets.h\"\n")
foreach(asset IN LISTS ASSETS)
  string(REGEX MATCH "^([^=]*)=(.*)$" unused "${asset}")
  set(name "${CMAKE_MATCH_1}")
  string(REPLACE "|" ";" paths "${CMAKE_MATCH_2}")
  set(hex "")
  foreach(path IN LISTS paths)
    file(READ "${path}" one HEX)
    string(APPEND hex "${one}")
  endforeach()
  string(LENGTH "${hex}" size)
  math(EXPR size "${size} / 2")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND text "static const unsigned char ${name}[] = {${bytes}0};\n"
    "const pl_asset pl_asset_${name} = {${name}, ${size}};\n")
endforeach()
file(WRITE "${OUT}" "${text}")
