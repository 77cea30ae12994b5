# cmake -Dthree=FOLDER -Dzstddec=FOLDER -Dpage=FOLDER -Dto=FOLDER -P prepare_page.cmake: the folder that browsers get, of this folder's files
# and those of two npm packages.

# Browsers find 'three' only by an import map, which stands in the page as a script and so needs an exception in the
# Content-Security-Policy: the name of the file takes its place.
function(copy_module from to)
  file(READ "${from}" text)
  string(REPLACE "from 'three'" "from './three.module.min.js'" text "${text}")
  string(REPLACE "from 'three/webgpu'" "from './three.webgpu.min.js'" text "${text}")
  file(WRITE "${to}" "${text}")
endfunction()

file(MAKE_DIRECTORY ${to})
foreach(file index.html style.css page.js decode_worker.js decode_team.js chunk_worker.js decoder.js stream_file.js zstandard.js)
  configure_file(${page}/${file} ${to}/${file} COPYONLY)
endforeach()
copy_module(${page}/drawing.js ${to}/drawing.js)
copy_module(${page}/drawing_webgpu.js ${to}/drawing_webgpu.js)
copy_module(${three}/examples/jsm/controls/OrbitControls.js ${to}/OrbitControls.js)
foreach(file three.module.min.js three.webgpu.min.js three.core.min.js)
  configure_file(${three}/build/${file} ${to}/${file} COPYONLY)
endforeach()

# Its class fetches its WebAssembly from a data: address, which the policy forbids: zstandard.js takes the WebAssembly itself.
file(READ ${zstddec}/dist/zstddec.mjs text)
if(NOT text MATCHES "\nconst wasm = ")
  message(FATAL_ERROR "${zstddec}/dist/zstddec.mjs is not of the version that ./build.sh fetches: it has no constant 'wasm'")
endif()
file(WRITE ${to}/zstddec.mjs "${text}\nexport { wasm };\n")

file(READ ${three}/LICENSE three_licence)
file(READ ${zstddec}/LICENSE zstddec_licence)
file(WRITE ${to}/licences.txt "three.js, https://threejs.org\n\n${three_licence}\n
zstddec, https://github.com/donmccurdy/zstddec-wasm, with Zstandard, https://facebook.github.io/zstd\n\n${zstddec_licence}")
